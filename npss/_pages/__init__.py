"""Self-contained HTML pages: the survey of a user study, and the report."""

from npss._pages.report import Figure, report_page
from npss._pages.survey import Part, Survey, survey, survey_page

__all__ = ["Figure", "Part", "Survey", "report_page", "survey", "survey_page"]
