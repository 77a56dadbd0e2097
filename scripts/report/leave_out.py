"""What scenes do not need: parts put in that change nothing, parts taken out that do, and what it saves to leave them out."""

import numpy as np
from matplotlib import figure

from report import studies
from report.drawing import NARROW, Figure, inline_svg, panels_of

ROUNDING = 1e-9  # relative changes below count as rounding
AS_IT_STANDS = "as it stands"


def ablations(results):
    """Results of ablations that no --set has changed, of which the case as it stands came to its end."""
    for result in results:
        record = result.records.get("ablate")
        if result.variant or record is None or not record.has("variant", "outcome", "moved", "parts_bytes", "origin"):
            continue
        if len(record) > 1 and record["variant"][0] == AS_IT_STANDS and record["outcome"][0] == "completed":
            yield result, record


def seconds_of(result):
    """Wall time of each row, None where rows ran side by side."""
    cost = result.records.get("ablate_cost")
    return None if cost is None or "one after another" not in cost.title else cost["wall_seconds"]


def rows(results):
    """A row for each variant: result, name, how far it moves the case, bytes and, of repeats, seconds more than the case takes."""
    found = []
    for result, record in ablations(results):
        seconds = medians_of(result)
        for row in range(1, len(record)):
            found.append(
                {
                    "result": result,
                    "variant": str(record["variant"][row]),
                    "origin": str(record["origin"][row]),
                    "outcome": str(record["outcome"][row]),
                    "moved": float(record["moved"][row]),
                    "bytes": float(record["parts_bytes"][row] - record["parts_bytes"][0]),
                    "seconds": None if seconds is None else float(seconds[row] - seconds[0]),
                }
            )
    return found


def effect(row):
    """What a variant does to its case, in words."""
    if not np.isfinite(row["moved"]):
        return "ends otherwise" if row["outcome"] != "completed" else "other numbers"
    if row["moved"] == 0:
        return "nothing, bit by bit"
    return "rounding" if row["moved"] < ROUNDING else "changes it"


def sentences(found):
    """How many parts were put in without effect, and how many changes of what is needed showed."""
    kept = [row for row in found if row["origin"] == "kept"]
    exact = [row for row in kept if row["moved"] == 0]
    rounded = [row for row in kept if 0 < row["moved"] < ROUNDING]
    others = [row for row in found if row["origin"] != "kept" and np.isfinite(row["moved"])]
    needed = [row for row in others if row["moved"] >= ROUNDING]
    scenes = len({row["result"].file for row in found})
    text = [
        f"{len(kept)} parts that {scenes} scenes leave out were built all the same: "
        f"{len(exact)} changed nothing, bit by bit; {len(rounded)} by rounding; {len(kept) - len(exact) - len(rounded)} more than that."
    ]
    if needed:
        least = min(needed, key=lambda row: row["moved"])
        text.append(
            f"{len(needed)} other changes of these scenes were seen, the least of them {least['moved']:.2g} "
            f"({least['result'].id}, {least['variant']})."
        )
    return text


def medians_of(result):
    """The same of repeats, None where each row ran once: one run's time says little of a difference."""
    return seconds_of(result) if seconds_of(result) is not None and studies.are_medians(result.records["ablate_cost"]) else None


def without_effect(result, record):
    """Rows of the variants that build more and change nothing beyond rounding."""
    more = record["parts_bytes"] - record["parts_bytes"][0]
    seconds = medians_of(result)
    longer = np.zeros(len(record)) if seconds is None else seconds - seconds[0]
    idle = (record["moved"] < ROUNDING) & (record["outcome"] == "completed")
    chosen = [row for row in range(1, len(record)) if idle[row] and (more[row] > 0 or longer[row] > 0)]
    return sorted(chosen, key=lambda row: -more[row])


def largest(results):
    """The ablation of the largest scene that left something out: timed ones first."""
    found = [(result, record) for result, record in ablations(results) if without_effect(result, record)]
    return max(found, key=lambda pair: (medians_of(pair[0]) is not None, pair[1]["parts_bytes"][0]), default=(None, None))


def saved(results):
    """What the largest scene saves by what it leaves out: memory, and time where rows were timed, of each part that was put in."""
    result, record = largest(results)
    if result is None:
        return None
    chosen, seconds = without_effect(result, record), medians_of(result)
    names = [str(record["variant"][row]).removeprefix("with ") for row in chosen]
    columns = [(np.array([record["parts_bytes"][row] - record["parts_bytes"][0] for row in chosen]) / 1e6, "MB")]
    if seconds is not None:
        columns.append((np.array([seconds[row] - seconds[0] for row in chosen]), "s"))
        cost = result.records["ablate_cost"]
        bars = [[abs(cost[f"{end}_wall_seconds"][row] - seconds[row]) for row in chosen] for end in ("min", "max")]
    drawing = figure.Figure(figsize=(NARROW, max(1.4, 0.8 + 0.22 * len(chosen))))
    panels = panels_of(drawing, 1, len(columns), sharey=True)[0]
    places = np.arange(len(chosen))
    for panel, (values, unit) in zip(panels, columns):
        panel.barh(places, values, color="C0", height=0.6, linewidth=0)
        if unit == "s":  # of repeats, from the fastest to the slowest
            panel.errorbar(values, places, xerr=bars, fmt="none", ecolor="#222222", elinewidth=1)
        panel.axvline(0, color="#555555", linewidth=0.8)
        panel.set_xlabel(f"more if built [{unit}]")
        panel.locator_params(axis="x", nbins=4)
        panel.set_xlim(min(0.0, 1.5 * values.min()), 1.3 * max(values.max(), 0.0) or 1.0)
        panel.set_ylim(len(chosen) - 0.4, -0.6)
        panel.grid_along = {"x"}
        for place, value in zip(places, values):
            panel.annotate(
                f"{value:.3g}".replace("-", "−"),
                (value, place),
                xytext=(3 if value >= 0 else -3, 0),
                textcoords="offset points",
                ha="left" if value >= 0 else "right",
                va="center",
            )
    panels[0].set_yticks(places, names)
    caption = (
        f"{result.title}: what each part would cost if it were built, all without effect. The scene takes {record['parts_bytes'][0] / 1e6:.4g} MB"
    )
    caption += f" and {seconds[0]:.3g} s, medians of repeats, bars from the fastest to the slowest." if seconds is not None else "."
    return Figure(caption, inline_svg(drawing, caption))
