"""The report: result files in (results), figures of a subject in a file of its own, one page out (../report.py)."""
