"""What a study shows, in one line: a part left out of its result would go unseen on a page of some fifty figures and tables."""

from validation.study import StudyResult


def parts(result: StudyResult) -> str:
    """Names of figures and tables; how many notes, numbers and omissions there are."""
    figures, tables = ([part.name for part in some] for some in (result.figures, result.tables))
    counts = f"{len(result.notes)} notes, {len(result.numbers)} numbers, {len(result.omissions)} omissions"
    return f"{' '.join(figures)} | {' '.join(tables)} | {counts}"
