"""The staggered velocity-stress leapfrog: its grid, media, outer faces and the marching kernel."""
