"""The report: runs the studies whose scene, code or settings changed, stores their results, writes one HTML page."""

from pathlib import Path


def make_report(
    out: Path = Path("reports"), quick: bool = False, only: list[str] | None = None, processes: int | None = None
) -> Path:
    """Write out/index.html, computing what is not already stored under out/data; returns the page's path.

    Studies run side by side in `processes` (default: one for each core); those that measure run time (`TIMED`) run alone at the
    end. A study that fails is shown as failed and the others go on. Once the page is written, RedReport (a NumericsError) is
    raised if a study or a verdict fails or a number left its baseline. An interrupted report resumes: finished studies are stored
    whole. Raises SceneError for an unknown name in `only`.
    """
    from validation.report.build import build_report

    return build_report(out, quick, only, processes)
