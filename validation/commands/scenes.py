"""`slipwave scenes`: the gallery, one line each."""

EXAMPLES = ("slipwave scenes",)


def scenes() -> None:
    """List the gallery's scenes, one line each."""
    from slipwave.input.source import gallery_titles

    titles = gallery_titles()
    width = max(map(len, titles))
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")
