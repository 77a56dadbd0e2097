"""Codes side by side: what other programs' numbers are off by, and this program's where it was asked the same."""

OURS = "veriflex"


def code_of(result):
    """Whose numbers a result holds."""
    return result.provenance.get("other_code", OURS)


def question_of(result):
    """Id of the case that asks the same of this program, which may be the result's own."""
    return result.provenance.get("other_code_case") or result.case_id


def cell(results, metrics):
    """Results of one code for one case, each with its checks of those metrics; a metric that is checked often, by its worst."""
    found = []
    for result in results:
        checks = {}
        for check in sorted(result.checks, key=lambda check: check.margin):
            if check.metric in metrics:
                checks[check.metric] = check
        found.append({"result": result, "checks": list(checks.values())})
    return found


def matrix(results_read):
    """Codes, this one first, and a row for each case that another code has numbers for; nothing without such results."""
    others = [result for result in results_read if code_of(result) != OURS]
    codes = [OURS, *sorted({code_of(result) for result in others})]
    rows = []
    for case in sorted({question_of(result) for result in others}):
        asked = [result for result in results_read if question_of(result) == case]
        metrics = {check.metric for result in asked if code_of(result) != OURS for check in result.checks}
        cells = [cell([result for result in asked if code_of(result) == code], metrics) for code in codes]
        rows.append({"case": case, "cells": cells})
    return {"codes": codes, "rows": rows} if rows else None
