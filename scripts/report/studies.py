"""Figures of studies over a case: sweeps, boundaries of outcomes, ablations."""

import os
import re
import tomllib

import numpy as np
from markupsafe import Markup
from matplotlib.lines import Line2D

from report.drawing import MARK, NARROW, TALL, Figure, canvas, column_label, drawable, inline_svg, label_points, legend_above, markers
from report.text import numeral, raised

MANY_METRICS, MANY_LINES = 4, 8  # panels of a figure, curves of a panel
WORDS_OF_ERRORS = ("error", "departure", "deviation", "difference")
NORM = re.compile(r"_(l1|l2|linf)$")


def parts(record):
    """Columns of a study's table: its axes, what was measured, which rows are complete."""
    names = list(record.columns)
    outcome, work = names.index("outcome"), names.index("node_updates")
    return names[:outcome], names[outcome + 1 : work], record["outcome"] == "completed"


def is_number(record, name):
    return record[name].dtype.kind in "iuf"


def errors_of(metrics):
    """What is an error by its name, those called so first."""
    found = [m for m in metrics if any(word in m for word in WORDS_OF_ERRORS)]
    return sorted(found, key=lambda name: not name.startswith("error"))


def asked(result, metrics):
    """The metrics worth a panel: those that a check names, errors, else the first; exact ones go with their own."""
    metrics = [m for m in metrics if not (m.endswith("_exact") and m.removesuffix("_exact") in metrics)]
    named = [m for m in metrics if any(names(check.metric, m) for check in result.checks)]
    return list(dict.fromkeys(named + errors_of(metrics) or metrics))


def names(question, metric):
    """Whether `order(error_l2) at ...` asks for that metric."""
    return re.search(rf"(?<![\w.]){re.escape(metric)}(?![\w.])", question) is not None


def in_panels(metrics):
    """Metrics by panel: norms of one error share one."""
    panels = {}
    for metric in metrics:
        panels.setdefault(NORM.sub("", metric), []).append(metric)
    return list(panels.items())[:MANY_METRICS]


def order_guide(panel, x, values):
    """Dotted, the slope of the nearest whole order between the two last points, below its curve."""
    drawn = (x > 0) & (values > 0)
    x, values = x[drawn], values[drawn]
    if len(x) < 2 or panel.get_xscale() != "log" or panel.get_yscale() != "log":
        return
    slope = round(np.log(values[-1] / values[-2]) / np.log(x[-1] / x[-2])) if x[-1] != x[-2] else 0
    if slope != 0:
        panel.plot(x, 0.5 * values[-1] * (x / x[-1]) ** slope, ":", color="#555555", linewidth=1)


def lines(record, axes, x):
    """Rows that differ along one axis only, with a label that says where the others stand."""
    others = [name for name in axes if name != x]
    groups = {}
    for row in range(len(record)):
        where = tuple(record[name][row] for name in others)
        groups.setdefault(where, []).append(row)
    for where, rows in groups.items():
        values = (f"{v:.6g}" if isinstance(v, float) else str(v).strip('"') for v in where)
        label = ", ".join(f"{short(name)} {value}" for name, value in zip(others, values))
        yield label, np.array(rows)


def scale(axes, x, y):
    """Logarithmic where all is positive and spans more than a factor of five."""
    for values, put in ((x, axes.set_xscale), (y, axes.set_yscale)):
        finite = values[np.isfinite(values)]
        if finite.size and finite.min() > 0 and finite.max() > 5 * finite.min():
            put("log")


def curves(record, chosen, x_name, x, caption):
    """A panel per metric: it against x, a curve for each value of the other axes."""
    axes, _, complete = parts(record)
    chosen = in_panels([m for m in chosen if np.isfinite(record[m]).sum() >= 2])
    if not chosen:
        return None
    drawing, panels = canvas(len(chosen), height=1.3 + 2.2 * len(chosen), sharex=True)
    handles, hints = [], []
    for panel, (stem, metrics) in zip(panels, chosen):
        own = []
        for number, ((label, rows), marker) in enumerate(zip(list(lines(record, axes, x_name))[:MANY_LINES], markers())):
            order = rows[np.argsort(x[rows], kind="stable")]
            for metric, style in zip(metrics, ("-", "--", "-.")):
                (handle,) = panel.plot(x[order], record[metric][order], marker + style, color=f"C{number}", label=label)
                where = f"{label}, " if label else ""
                told = zip(x[order], record[metric][order])
                hints += [(panel, at, y, f"{where}{short(x_name)} {at:.6g}: {metric} {y:.6g}") for at, y in told]
                if len(metrics) > 1 and number == 0:
                    own.append(Line2D([], [], linestyle=style, color="#555555", label=metric.removeprefix(stem).strip("_")))
                if metric + "_exact" in record.columns:
                    panel.plot(x[order], record[metric + "_exact"][order], "-", color="#222222", linewidth=0.7, zorder=1)
                if panel is panels[0] and label and metric == metrics[0]:
                    handles.append(handle)
        scale(panel, x, np.concatenate([record[metric] for metric in metrics]))
        _, rows = next(lines(record, axes, x_name))
        if stem.startswith("error"):
            order_guide(panel, x[rows], record[metrics[0]][rows])
        title = column_label(record.columns[metrics[0]]) if len(metrics) == 1 else f"{stem.strip('_').replace('_', ' ')} [1]"
        exact = ", thin: exact" if any(metric + "_exact" in record.columns for metric in metrics) else ""
        panel.set_title(title + exact, loc="left")
        panel.margins(x=0.06, y=0.12)
        legend_above(panel, own)
    for row in np.flatnonzero(~complete & np.isfinite(x)):
        panels[-1].annotate("×", (x[row], 0), xycoords=("data", "axes fraction"), ha="center", color="#B03030")
    if panels[-1].get_xscale() == "log":
        label_points(panels[-1], np.unique(x[np.isfinite(x)]))
    panels[0].legend_handles = handles + panels[0].legend_handles
    lost = int((~complete).sum())
    if lost:
        caption += f" × marks {lost} of {len(record)} runs that did not complete; see the table."
    return panels, drawing, caption, hints


def sweep(result, record):
    """Metrics along the last axis of numbers."""
    axes, metrics, _ = parts(record)
    along = [name for name in axes if is_number(record, name) and len(set(record[name])) > 1]
    if not along:
        return None
    x = record.columns[along[-1]]
    drawn = curves(record, asked(result, metrics), x.name, x.values, f"{record.title}.")
    if drawn is None:
        return None
    panels, drawing, caption, hints = drawn
    panels[-1].set_xlabel(x.name.replace("_", " "))
    return Figure(caption, inline_svg(drawing, caption, hints))


def are_medians(cost):
    """Whether times are those of repeats, made one after another: only then they are worth a picture."""
    return "one after another" in cost.title and "median" in cost.columns["wall_seconds"].meaning


def sweep_cost(result, record):
    """Errors against run time, of sweeps that were timed with repeats and have no front."""
    table = result.records.get("sweep")
    if table is None or "sweep_cost_front" in result.records or not are_medians(record):
        return None
    axes, metrics, _ = parts(table)
    along = [name for name in axes if is_number(table, name) and len(set(table[name])) > 1]
    x_name = along[-1] if along else axes[-1]
    caption = "What accuracy a second of computing buys; medians of repeats."
    drawn = curves(table, errors_of(metrics)[:MANY_METRICS], x_name, record["wall_seconds"], caption)
    if drawn is None:
        return None
    panels, drawing, caption, hints = drawn
    for panel, (_, names_of_panel) in zip(panels, in_panels([m for m in errors_of(metrics)[:MANY_METRICS] if np.isfinite(table[m]).sum() >= 2])):
        errors = np.abs(table[names_of_panel[0]])
        spread(panel, record, record["wall_seconds"], errors, np.isfinite(errors) & (errors > 0))
    panels[-1].set_xlabel("run time of the row [s]")
    return Figure(caption, inline_svg(drawing, caption, hints))


def short(name):
    """Name of an axis without the tables it stands in; an entry of a list keeps the list's name."""
    *_, before, last = ["", *name.split(".")]
    return (f"{before} {last}" if last.isdigit() else last).replace("_", " ")


def setting(record, row, axes):
    """The values of a row's axes in words."""
    values = ((name, record[name][row]) for name in axes)
    return ", ".join(f"{short(name)} {v:.6g}" if isinstance(v, float) else str(v) for name, v in values)


def axes_of(record, error):
    """Names of the axes of a front: the columns before its error."""
    names = list(record.columns)
    return names[: names.index(error)]


def priced(result, front):
    """Error and price of every row of the sweep whose front this is, and the front's columns of both."""
    error, price = list(front.columns.values())[-2:]
    table = result.records["sweep"]
    prices = result.records["sweep_cost"] if price.name not in table.columns else table
    return error, price, np.abs(table[error.name]), prices[price.name]


def front(result, record):
    """All settings of a sweep by error and price: those that another beats are grey, the others are the front."""
    if "sweep" not in result.records or len(record) < 2:
        return None
    error, price, errors, prices = priced(result, record)
    outcomes = result.records["sweep"]["outcome"]
    drawing, (panel,) = canvas()
    seen = (errors > 0) & np.isfinite(errors)
    handles = panel.plot(prices[seen], errors[seen], "o", color="#B8BCC0", markersize=4, label="beaten by another setting")
    if "sweep_cost" in result.records and price.name == "wall_seconds":
        spread(panel, result.records["sweep_cost"], prices, errors, seen)
    best = error.values > 0
    handles += panel.plot(price.values[best], error.values[best], "s-", color="C0", label="worth its price")
    table, axes = result.records["sweep"], axes_of(record, error.name)
    hints = [(panel, prices[row], errors[row], told(setting(table, row, axes), errors[row], prices[row], price.name)) for row in np.flatnonzero(seen)]
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.margins(x=0.08, y=0.1)
    for number, outcome in enumerate(sorted(set(outcomes) - {"completed"})):
        lost = (outcomes == outcome) & np.isfinite(prices) & (prices > 0)
        handles += panel.plot(
            prices[lost],
            np.full(lost.sum(), 1.0),
            "x+1*"[number % 4],
            color="#B03030",
            transform=panel.get_xaxis_transform(),
            clip_on=False,
            label=str(outcome),
        )
    panel.set_xlabel(price_label(price))
    panel.set_ylabel(column_label(error))
    caption = "What accuracy costs: every setting of the sweep, and those that no other beats in both."
    measured, expected = slope_of(result, record)
    if measured is not None:
        caption += f" Along the front the error falls with the power {measured:.2f} of the price."
    if expected is not None:
        x = price.values[best]
        handles += panel.plot(x, error.values[best][-1] * (x / x[-1]) ** expected, ":", color="#555555", label=f"power {expected:.3g}, by theory")
    legend_above(panel, handles)
    if price.name == "wall_seconds":
        caption += " Times are medians, bars reach from the fastest to the slowest repeat."
    return Figure(caption, inline_svg(drawing, caption, hints))


def slope_of(result, record):
    """With which power of its price the error falls along a front: measured by least squares over three points or more, and what the case expects."""
    error, price = list(record.columns.values())[-2:]
    best = (error.values > 0) & (price.values > 0)
    measured = float(np.polyfit(np.log(price.values[best]), np.log(error.values[best]), 1)[0]) if best.sum() > 2 else None
    expected = tomllib.loads(result.case_text).get("sweep", {}).get("expected_slope")
    return measured, expected if best.sum() > 1 else None


def price_label(price):
    """Label of the axis of what an error costs."""
    return {"wall_seconds": "run time [s]", "bytes_moved": "memory traffic [byte]"}.get(price.name) or column_label(price)


def spread(panel, cost, prices, errors, seen):
    """Bars from the fastest to the slowest repeat."""
    low, high = (np.abs(cost[f"{end}_wall_seconds"] - prices)[seen] for end in ("min", "max"))
    panel.errorbar(prices[seen], errors[seen], xerr=(low, high), fmt="none", ecolor="#B8BCC0", elinewidth=0.8, zorder=0)


def told(where, error, price, name):
    """What the page says of a setting under the pointer."""
    amount = f"{price:.3g} s" if name == "wall_seconds" else f"{price:.3g} {name.replace('_', ' ')}"
    return raised(f"{where}: error {error:.3g}, {amount}")


def families(results):
    """Results whose sweep says what its error costs: with the front by run time if rows were timed, else by work."""
    found = []
    for result in results:
        record = result.records.get("sweep_cost_front") or result.records.get("sweep_front")
        if record is not None and len(record) and not result.variant:
            found.append((result, record))
    return found


SUBJECTS = ("solid alone", "fluid alone", "body in a fluid")
ROUNDING = 1e-16  # an error below is none that a picture could tell from it


def subject(result):
    """Number of the subject of a family."""
    return 2 if {"coupling", "filament"} & set(result.topics) else 1 if "fluid" in result.topics else 0


def error_against_time(results, whole=False):
    """The fronts of all families in one picture, what they beat in grey: by run time if any was timed, else by work; None without any. The whole picture names
    each family, the panel of the first screen their subjects."""
    found = families(results)
    timed = [(result, record) for result, record in found if record.name == "sweep_cost_front"]
    found = timed or found
    drawing, (panel,) = canvas(height=5.2) if whole else canvas(width=NARROW, height=TALL)
    handles, hints, lost = [], [], {}
    prefix = os.path.commonprefix([result.id for result, _ in found]).rpartition("-")[0]
    for number, ((result, record), marker) in enumerate(zip(found, markers())):
        error, price = list(record.columns.values())[-2:]
        best = error.values > ROUNDING
        if not best.any():
            continue
        color, style = (f"C{number % MANY_LINES}", ("-", "--", "-.")[number // MANY_LINES % 3]) if whole else (f"C{subject(result)}", "-")
        (line,) = panel.plot(price.values[best], error.values[best], marker + style, color=color, label=result.id.removeprefix(prefix + "-"))
        handles.append(line)
        axes = axes_of(record, error.name)
        for row in np.flatnonzero(best):
            where = f"{result.id}, {setting(record, row, axes)}"
            hints.append((panel, price.values[row], error.values[row], told(where, error.values[row], price.values[row], price.name)))
        if "sweep" in result.records:
            _, _, errors, prices = priced(result, record)
            seen = (errors > ROUNDING) & np.isfinite(errors)
            if whole:
                panel.plot(prices[seen], errors[seen], ".", color="#B8BCC0", markersize=3, zorder=0)
            outcomes = result.records["sweep"]["outcome"]
            for outcome in sorted(set(outcomes) - {"completed"}):
                lost.setdefault(str(outcome), []).extend(prices[(outcomes == outcome) & (prices > 0)])
    if not handles:
        return None
    if not whole:
        drawn = sorted({subject(result) for result, _ in found})
        handles = [Line2D([], [], color=f"C{number}", label=SUBJECTS[number]) for number in drawn]
    panel.set_xscale("log")
    panel.set_yscale("log")
    for number, (outcome, places) in enumerate(sorted(lost.items())):
        style = dict(color="#B03030", linestyle="none", transform=panel.get_xaxis_transform(), clip_on=False)
        handles += panel.plot(places, np.full(len(places), 1.0), "x+1*"[number % 4], label=f"fails: {outcome}", **style)
    panel.set_xlabel(price_label(price))
    panel.set_ylabel("error [1]")
    panel.margins(x=0.06, y=0.08)
    legend_above(panel, handles)
    caption = "Error against run time" if timed else "Error against work"
    caption += ": for each family the settings that no other beats"
    caption += ", in grey those that are beaten. Each error is what its case says it is." if whole else "."
    caption += " Times are medians of repeats." if timed else ""
    return Figure(caption, inline_svg(drawing, caption, hints))


def methods(results):
    """Families that ask the same of other methods: those whose id goes on where another's ends. A list of such lists."""
    found = families(results)
    groups = []
    for first, record in found:
        error = list(record.columns)[-2]
        others = [(result, front) for result, front in found if result.id.startswith(first.id + "-") and list(front.columns)[-2] == error]
        if others and record.name == "sweep_cost_front":
            groups.append([(first, record), *others])
    return groups


def not_beaten(prices, errors):
    """The rows that no other beats in both, by price."""
    best, least = [], np.inf
    for row in np.lexsort((errors, prices)):
        if errors[row] > ROUNDING and errors[row] < least and np.isfinite(prices[row]):
            best.append(row)
            least = errors[row]
    return best


def method_lines(result, front_record):
    """Of a sweep of several axes a line for each value of the first, else one: label, rows, errors, prices in work and in seconds."""
    table = result.records["sweep"]
    axes = axes_of(front_record, list(front_record.columns)[-2])
    work = list(result.records["sweep_front"].columns)[-1]
    errors = np.abs(table[list(front_record.columns)[-2]])
    first = table[axes[0]] if len(axes) > 1 else np.full(len(table), "")
    for value in dict.fromkeys(first.tolist()):
        label = value if isinstance(value, str) else f"{short(axes[0])} {value:g}"
        yield f"{result.id}{', ' if label else ''}{label}", np.flatnonzero(first == value), errors, (table[work], result.records["sweep_cost"]["wall_seconds"])


def of_methods(group):
    """What accuracy costs by several methods, in work and in run time: of each the settings that it itself does not beat."""
    drawing, panels = canvas(2, height=7.2)
    handles, hints = [], []
    shared = group[0][0].id
    lines_of_all = [(result, *line) for result, record in group for line in method_lines(result, record)]
    for number, ((result, label, rows, errors, prices), marker) in enumerate(zip(lines_of_all, markers())):
        table, axes = result.records["sweep"], axes_of(result.records["sweep_front"], list(result.records["sweep_front"].columns)[-2])
        for panel, price in zip(panels, prices):
            best = rows[not_beaten(price[rows], errors[rows])]
            if not len(best):
                continue
            name = label.removeprefix(shared).strip(", -") or shared
            handle = panel.plot(price[best], errors[best], marker + "-", color=f"C{number % MANY_LINES}", label=name)
            if panel is panels[0]:
                handles += handle
            price_name = list(result.records["sweep_front"].columns)[-1] if panel is panels[0] else "wall_seconds"
            hints += [(panel, price[row], errors[row], told(f"{result.id}, {setting(table, row, axes)}", errors[row], price[row], price_name)) for row in best]
    for panel in panels:
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.margins(x=0.06, y=0.08)
        panel.set_ylabel(column_label(list(group[0][1].columns.values())[-2]))
    panels[0].set_xlabel(price_label(list(group[0][0].records["sweep_front"].columns.values())[-1]))
    panels[1].set_xlabel("run time [s]")
    legend_above(panels[0], handles)
    caption = f"{group[0][0].title}, and by other methods. Of each the settings that none of its own beats in both; times are medians of repeats."
    return Figure(caption, inline_svg(drawing, caption, hints))


def answers(results, wanted=(1e-2, 1e-3, 1e-4)):
    """Rows (result, error asked, setting, error, seconds, next step) of the cheapest settings of all families."""
    rows = []
    for result, record in families(results):
        name = record.name.replace("_front", "_reached")
        reached = result.records.get(name)
        if reached is None:
            continue
        error, price = list(record.columns.values())[-2:]
        axes = axes_of(record, error.name)
        for ask in wanted:
            at = np.flatnonzero(np.isclose(reached["asked"], ask))
            if at.size == 0:
                continue
            row = int(at[0])
            rows.append(
                {
                    "result": result,
                    "asked": ask,
                    "setting": setting(reached, row, axes),
                    "error": float(reached[error.name][row]),
                    "price": float(reached[price.name][row]),
                    "timed": price.name == "wall_seconds",
                    "unit": price.name.replace("_", " "),
                    "next": str(reached["next_step"][row]),
                }
            )
    return rows


def slopes(results):
    """Rows (result, measured, expected) of the powers with which errors fall along the fronts."""
    rows = [(result, *slope_of(result, record)) for result, record in families(results)]
    return [{"result": result, "measured": measured, "expected": expected} for result, measured, expected in rows if measured is not None]


def settings_by_axis(results):
    """Of each family and each axis: result, axis, table of settings, and its rows of that axis."""
    for result, record in families(results):
        table = result.records.get(record.name.replace("_front", "_settings"))
        if table is not None:
            for axis in dict.fromkeys(table["axis"]):
                yield result, axis, table, np.flatnonzero(table["axis"] == axis)


def cheapest_ranges(results):
    """Rows (result, axis, settings): for which errors each value of an axis is the cheapest, of axes on which that changes."""
    rows = []
    for result, axis, table, at in settings_by_axis(results):
        at = sorted(at[np.isfinite(table["cheapest_from"][at])], key=lambda row: -table["cheapest_from"][row])
        if len(at) > 1:
            parts = [Markup("{} {}").format(table["value"][row], between(table["cheapest_from"][row], table["cheapest_below"][row])) for row in at]
            rows.append({"result": result, "axis": axis, "settings": Markup("; ").join(parts)})
    return rows


def between(low, high):
    least = Markup("from {} ").format(numeral(low, 2))
    return least + "up" if np.isinf(high) else least + Markup("to {}").format(numeral(high, 2))


def never_worth(results):
    """Rows (result, axis, settings) of values that are the cheapest for no error."""
    rows = []
    for result, axis, table, at in settings_by_axis(results):
        never = at[np.isnan(table["cheapest_from"][at]) & np.isfinite(table["work_over_cheapest"][at])]
        parts = [f"{table['value'][row]} ({table['work_over_cheapest'][row]:.3g} times dearer at best)" for row in never]
        if parts:
            rows.append({"result": result, "axis": axis, "settings": ", ".join(parts)})
    return rows


def is_curve_of_numbers(record):
    """Whether it is what a check of a study asks for, such as `richardson(viscosity)`."""
    return "(" in record.name


def curve_of_numbers(result, record):
    """One number of a study for each value of an axis, beside its reference."""
    x, y = record.columns.values()
    drawing, (axes,) = canvas()
    handles = axes.plot(x.values, y.values, "o", mfc="none", label=record.name)
    for reference in result.references:
        if drawable(reference.columns, x.name, y.name):
            points = reference.columns
            handles += axes.plot(points[x.name], points[y.name], "-", color="#222222", linewidth=0.8, label=reference.kind)
    axes.axhline(0, **MARK)
    axes.set_xlabel(x.name.replace("_", " "))
    axes.set_ylabel(column_label(y))
    legend_above(axes, handles)
    caption = f"{record.title}."
    return Figure(caption, inline_svg(drawing, caption))


def outcome_boundary(result, record):
    """Where the outcome changes, along the last axis of numbers."""
    names = list(record.columns)
    axes = names[: names.index("boundary")]
    along = [name for name in axes if is_number(record, name) and len(set(record[name])) > 1]
    if not along or np.isfinite(record["boundary"]).sum() < 2:
        return None
    x = record.columns[along[-1]]
    drawing, (panel,) = canvas()
    handles = []
    for number, ((label, rows), marker) in enumerate(zip(list(lines(record, axes, x.name))[:MANY_LINES], markers())):
        middle, before, behind = (record[name][rows] for name in ("boundary", "before", "behind"))
        handles += panel.plot(x.values[rows], middle, marker + "-", color=f"C{number}", label=label)
        panel.errorbar(x.values[rows], middle, yerr=np.abs(behind - before) / 2, fmt="none", ecolor=f"C{number}")
    scale(panel, x.values, record["boundary"])
    panel.set_xlabel(x.name.replace("_", " "))
    panel.set_ylabel("boundary")
    panel.margins(x=0.06, y=0.12)
    if len(handles) > 1:
        legend_above(panel, handles)
    caption = f"{record.title}; bars: between the two runs that bracket it."
    return Figure(caption, inline_svg(drawing, caption))


def ablate_difference(result, record):
    """How far each variant moves each metric, the most moved first."""
    size = np.abs(record["relative_difference"])
    # What is rounding beside other metrics of the case moves by any factor.
    largest = np.nanmax(np.abs(record["of_case"]), initial=0.0)
    moved = {}
    for metric, value, of_case in zip(record["metric"], size, np.abs(record["of_case"])):
        if np.isfinite(value) and of_case > 1e-9 * largest:
            moved[metric] = max(moved.get(metric, 0.0), value)
    metrics = sorted((m for m in moved if moved[m] > 0), key=moved.get)[-12:]
    if not metrics:
        return None
    variants = list(dict.fromkeys(record["variant"]))
    drawing, (panel,) = canvas(height=1.0 + 0.26 * len(metrics) + 0.16 * len(variants))
    handles = []
    for number, (variant, marker) in enumerate(zip(variants, markers())):
        at = {m: v for m, v, whose in zip(record["metric"], size, record["variant"]) if whose == variant}
        places = [(at[m], i) for i, m in enumerate(metrics) if at.get(m, 0) > 0]
        xs, ys = ([p[k] for p in places] for k in (0, 1))
        handles += panel.plot(xs, ys, marker, color=f"C{number}", label=str(variant))
    panel.set_xscale("log")
    panel.set_yticks(range(len(metrics)), [m.replace("_", " ") for m in metrics])
    panel.set_xlabel("relative difference [1]")
    legend_above(panel, handles)
    caption = "How far each variant moves the metrics of the case; what it does not move is not shown."
    return Figure(caption, inline_svg(drawing, caption))
