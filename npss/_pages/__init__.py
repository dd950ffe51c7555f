"""Self-contained HTML pages: the survey of a user study, and the report."""

from npss._pages.report import Figure, report_page
from npss._pages.survey import Part, survey, survey_page

__all__ = ["Figure", "Part", "report_page", "survey", "survey_page"]
