"""A matplotlib figure as a small SVG in the colours of the page.

matplotlib keeps data, scales, limits and ticks, and hands each line, patch and image to `Canvas`. Axes, legends and the layout are
written here: matplotlib's own take ten times as long and its SVG six times as many bytes. Coordinates are whole tenths of a point.
"""

import base64
import io
import math
import re
from html import escape

import numpy as np
from matplotlib import ticker
from matplotlib.backend_bases import GraphicsContextBase, RendererBase
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Bbox
from PIL import Image  # comes with matplotlib

from report.text import raised

SCALE = 10  # units of the drawing in a point
TEXT = 9  # points
LINE, TICKS, GAP = 12, 10.5, 4  # heights of a line of text, of tick labels, and a distance
STROKE = 1.6  # the stylesheet's width of lines
MANY_MARKERS = 60  # of more those that cover each other by half are left out
# Colours of the style sheet, of marks and of shades by their names in the page's style, which has others in the dark.
NAMES = {
    "#0072b2": "c0", "#d55e00": "c1", "#009e73": "c2", "#9c4f7f": "c3", "#000000": "c4", "#8a6d00": "c5",
    "#222222": "ink", "#333333": "ink", "#555555": "soft", "#444444": "soft", "#888888": "soft", "#808080": "soft",
    "#b8bcc0": "pale", "#bbbbbb": "pale", "#cccccc": "pale", "#b03030": "bad", "#ffffff": "paper",
    "#8db4d6": "b0", "#bcd4e8": "b1", "#e1ecf5": "b2",
}  # fmt: skip
RELATIVE = {Path.LINETO: ("l", 1), Path.CURVE3: ("q", 2), Path.CURVE4: ("c", 3)}


def width_of(text, size=TEXT):
    """About how wide a text is, in points, in the sans-serif faces of the page."""
    narrow, wide = sum(c in "iljtfr.,:;'|!()[] /" for c in text), sum(c.isupper() or c in "mw%×→−" for c in text)
    raised = sum(c in "⁰¹²³⁴⁵⁶⁷⁸⁹⁻" for c in text)
    return size * (0.31 * narrow + 0.72 * wide + 0.45 * raised + 0.55 * (len(text) - narrow - wide - raised))


def joined(numbers):
    """Whole numbers as path data has them: a minus sign is separator enough."""
    text = "".join(f"{number}" if number < 0 else f" {number}" for number in numbers)
    return text.removeprefix(" ")


def path_data(path, relative_to=None):
    """Path data of a path in units of the drawing; with `relative_to` all of it is relative, for use at many places."""
    data, at, letter = [], relative_to, ""
    steps = zip(path.vertices, path.codes) if path.codes is not None else zip(path.vertices, [1] + [2] * (len(path.vertices) - 1))
    for vertex, code in steps:
        if code == Path.STOP:
            break
        if code == Path.CLOSEPOLY:
            data.append("z")
            letter = ""
            continue
        points = [tuple(int(x) for x in np.rint(vertex))]
        if code == Path.MOVETO:
            data.append(("M" + joined(points[0])) if relative_to is None else "m" + joined(np.subtract(points[0], at)))
            at, letter = points[0], ""
            continue
        sign, count = RELATIVE[code]
        for _ in range(count - 1):
            points.append(tuple(int(x) for x in np.rint(next(steps)[0])))
        shifts = [(x - at[0], y - at[1]) for x, y in points]
        at = points[-1]
        if not any(x or y for x, y in shifts):
            continue
        if sign == "l" and 0 in shifts[0]:  # along an axis one number tells
            sign = "v" if shifts[0][0] == 0 else "h"
            shifts = [[sum(shifts[0])]]
        numbers = joined([number for shift in shifts for number in shift])
        data.append(sign + numbers if sign != letter else numbers if numbers.startswith("-") else " " + numbers)
        letter = sign
    return "".join(data)


class Canvas(RendererBase):
    """Takes what artists draw."""

    def __init__(self, width, height):
        super().__init__()
        self.width, self.height = width, height
        self.parts = []
        self.flip = Affine2D().scale(SCALE, -SCALE).translate(0, SCALE * height)

    def get_canvas_width_height(self):
        return self.width, self.height

    def get_text_width_height_descent(self, s, prop, ismath):
        size = prop.get_size_in_points()
        return width_of(s, size), 0.95 * size, 0.22 * size

    def option_image_nocomposite(self):
        return True

    def option_scale_image(self):
        return True

    def style(self, gc, face):
        """Attributes of a path: colours as classes where the page knows them, what is usual left out."""
        classes, attributes = [], []
        alpha = gc.get_alpha()
        if face is not None and face[3:] != (0.0,):
            name = NAMES.get(to_hex(face))
            classes += [f"f-{name}"] if name else []
            attributes += [] if name else [f'fill="{to_hex(face)}"']
        if gc.get_linewidth() > 0 and gc.get_rgb()[3] > 0:
            colour = to_hex(gc.get_rgb())
            name = NAMES.get(colour)
            classes += [f"s-{name}"] if name else []
            attributes += [] if name else [f'stroke="{colour}"']
            if gc.get_linewidth() != STROKE:
                attributes.append(f'style="--w:{SCALE * gc.get_linewidth():.0f}"')
            _, dashes = gc.get_dashes()
            if dashes is not None:
                attributes.append(f'stroke-dasharray="{joined(round(SCALE * dash) for dash in dashes)}"')
        if alpha is not None and alpha < 1:
            attributes.append(f'opacity="{alpha:.2g}"')
        return "".join([f' class="{" ".join(classes)}"' if classes else "", *(" " + text for text in attributes)])

    def add_path(self, data, style):
        if data:
            self.parts.append(f'<path{style} d="{data}"/>')

    def draw_path(self, gc, path, transform, rgbFace=None):
        path, clip = transform.transform_path(path), gc.get_clip_rectangle()
        filled = rgbFace is not None
        if filled and clip is not None and not np.any(path.codes == Path.CURVE4):
            inside = clip.containsx(path.get_extents().x0) and clip.containsx(path.get_extents().x1)
            inside = inside and clip.containsy(path.get_extents().y0) and clip.containsy(path.get_extents().y1)
            path = path if inside else path.clip_to_bbox(clip)
        line = path.codes is None or not np.isin(path.codes, (Path.CURVE3, Path.CURVE4)).any()
        box = None if filled or clip is None else clip.extents
        path = path.cleaned(clip=box, simplify=line and not filled, curves=True, remove_nans=True)
        self.add_path(path_data(self.flip.transform_path(path)), self.style(gc, rgbFace))

    def draw_markers(self, gc, marker_path, marker_trans, path, trans, rgbFace=None):
        places = trans.transform(path.vertices)
        places = places[np.isfinite(places).all(axis=1)]
        clip = gc.get_clip_rectangle()
        if clip is not None:
            room = Bbox.from_extents(*(clip.extents + (-0.6, -0.6, 0.6, 0.6)))
            places = places[[room.contains(*place) for place in places]] if len(places) else places
        mark = marker_trans.transform_path(marker_path)
        if len(places) > MANY_MARKERS:
            _, first = np.unique(np.rint(places / max(1.5, np.ptp(mark.vertices[:, 0]) / 2)), axis=0, return_index=True)
            places = places[np.sort(first)]
        spots = np.rint(self.flip.transform(places)).astype(int) if len(places) else []
        circle = marker_path.codes is not None and np.isin(marker_path.codes, Path.CURVE4).any()
        colour = to_hex(gc.get_rgb())
        if circle and rgbFace is not None and to_hex(rgbFace) == colour:  # a dot is the round end of a stroke without length
            wide = SCALE * (np.ptp(mark.vertices[:, 0]) + gc.get_linewidth())
            name = NAMES.get(colour)
            style = f' class="dot s-{name}"' if name else f' class="dot" stroke="{colour}"'
            steps = [("M", spots[0])] if len(spots) else []
            steps += [("m", b - a) for a, b in zip(spots, spots[1:])]
            self.add_path("".join(f"{sign}{joined(step)}h0" for sign, step in steps), f'{style} style="--w:{wide:.0f}"')
            return
        if circle:
            radius = round(SCALE * (mark.vertices[:, 0].max() - mark.vertices[:, 0].min()) / 2)
            start, shape = (-radius, 0), f"a{radius} {radius} 0 10{2 * radius} 0 {radius} {radius} 0 10-{2 * radius} 0"
        else:
            outline = Affine2D().scale(SCALE, -SCALE).transform_path(mark)
            start, shape = np.rint(outline.vertices[0]).astype(int), path_data(outline, relative_to=(0, 0)).lstrip("m-0123456789 ")
        if circle or shape.endswith("z"):  # ends where it starts, from where the next one is told
            steps = [("M", spots[0] + start)] if len(spots) else []
            steps += [("m", b - a) for a, b in zip(spots, spots[1:])]
        else:
            steps = [("M", spot + start) for spot in spots]
        self.add_path("".join(f"{sign}{joined(step)}{shape}" for sign, step in steps), self.style(gc, rgbFace))

    def draw_image(self, gc, x, y, im, transform=None):
        width, height = (transform.get_matrix()[i, i] for i in (0, 1)) if transform is not None else im.shape[1::-1]
        shown, file = Image.fromarray(np.asarray(im)[::-1]), io.BytesIO()
        shown.convert("RGB").quantize(64).save(file, "png", optimize=True)
        left, top = self.flip.transform((x, y + height))
        picture = base64.b64encode(file.getvalue()).decode("ascii")
        self.parts.append(
            f'<image x="{left:.0f}" y="{top:.0f}" width="{SCALE * width:.0f}" height="{SCALE * height:.0f}" '
            f'preserveAspectRatio="none" href="data:image/png;base64,{picture}"/>'
        )

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        at = "start"
        if mtext is not None and not angle:
            at = {"center": "middle", "right": "end"}.get(mtext.get_horizontalalignment(), "start")
            wide = width_of(s, prop.get_size_in_points())
            x += {"start": 0, "middle": wide / 2, "end": wide}[at]
        name = NAMES.get(to_hex(gc.get_rgb()), "ink")
        self.text(x, self.height - y, s, at, angle=angle, size=prop.get_size_in_points(), name=name)

    def text(self, x, y, text, at="start", angle=0, size=TEXT, name="ink"):
        """A line of text, y of its base line from below."""
        left, base = (round(value) for value in self.flip.transform((x, y)))
        attributes = f'x="{left}" y="{base}"'
        attributes += f' transform="rotate({-angle:.0f} {left} {base})"' if angle else ""
        attributes += f' font-size="{SCALE * size:.0f}"' if abs(size - TEXT) > 0.3 else ""
        classes = ([f"f-{name}"] if name != "ink" else []) + ([at[0]] if at != "start" else [])
        attributes += f' class="{" ".join(classes)}"' if classes else ""
        self.parts.append(f"<text {attributes}>{escape(text.replace(chr(92) + '$', '$'), quote=False)}</text>")


class Side:
    """Ticks of one axis within its limits, with their labels."""

    def __init__(self, axis):
        low, high = sorted(axis.get_view_interval())
        places = np.asarray(axis.get_majorticklocs(), dtype=float)
        formatter = axis.get_major_formatter()
        # Rounding is relative to the range, or on a logarithmic axis to its ends.
        below, above = (1e-9 * abs(low), 1e-9 * abs(high)) if axis.get_scale() == "log" else (1e-9 * (high - low),) * 2
        places = places[(places >= low - below) & (places <= high + above)]
        if axis.get_scale() == "log" and len(places) < 2 and not isinstance(axis.get_major_locator(), ticker.FixedLocator):
            places = np.array([m * 10.0**e for e in range(-30, 30) for m in (1, 2, 5) if low <= m * 10.0**e <= high])
            if len(places) < 2:
                places = ticker.MaxNLocator(4).tick_values(low, high)[1:-1]
            labels = [raised(f"{place:.3g}") for place in places]
        else:
            labels = formatter.format_ticks(places)
        self.places, self.labels = places, [str(label).replace("-", "−") for label in labels]
        shown = axis._major_tick_kw.get("label1On", True)
        self.offset = formatter.get_offset() if shown else ""
        self.labels = self.labels if shown else [""] * len(places)
        self.title = axis.get_label_text()
        self.widest = max(map(width_of, self.labels), default=0)


class Frame:
    """What stands around a panel, and how much room it takes."""

    def __init__(self, axes, width):
        self.axes = axes
        self.x, self.y = Side(axes.xaxis), Side(axes.yaxis)
        self.legend = rows_of_legend(axes.legend_handles, width - 8)
        self.title = axes.get_title(loc="left")
        titles = self.y.title.split("\n") if self.y.title else []
        self.left = (LINE * len(titles) + 3) + (self.y.widest + GAP if self.y.widest else GAP)
        self.right = max(GAP, width_of(self.x.labels[-1]) / 2 if self.x.labels else 0)
        self.slanted = False
        self.top = LINE * len(self.legend) + (LINE if self.title else 0) + (LINE if self.y.offset else 0) + 5
        self.bottom = 2 + (TICKS + 2 if self.x.widest else 0) + (LINE + 1 if self.x.title else 0)

    def slant(self, width):
        """Labels that would touch are slanted; the room below grows."""
        spots = sorted((self.axes.transData.transform((place, 1))[0], width_of(text)) for place, text in zip(self.x.places, self.x.labels))
        steps = [(b[0] - a[0], (a[1] + b[1]) / 2 + 3) for a, b in zip(spots, spots[1:])]
        scale = width / self.axes.bbox.width
        self.slanted = any(step * scale < need for step, need in steps)
        if self.slanted:
            self.bottom += 0.6 * self.x.widest - 2


def rows_of_legend(handles, room):
    """Entries of a legend in rows that fit."""
    rows, used = [], math.inf
    for handle in handles:
        wide = 24 + width_of(str(handle.get_label())) + 12
        if used + wide > room:
            rows.append([])
            used = 0
        rows[-1].append((used, handle))
        used += wide
    return rows


def place(drawing, width, height):
    """Gives each panel of the drawing's grid its place; returns the frames."""
    frames, outgrown = placed(drawing, width, height)
    return placed(drawing, width, height)[0] if outgrown else frames


def placed(drawing, width, height):
    """The frames, and whether a panel has wider labels now, with other ticks at its new size, than room was left for."""
    frames = [Frame(axes, width) for axes in drawing.axes if axes.get_visible()]
    spans = [frame.axes.get_subplotspec() for frame in frames]
    columns, rows = spans[0].get_gridspec().ncols, spans[0].get_gridspec().nrows
    ratios = spans[0].get_gridspec().get_height_ratios()

    def most(side, which, index):
        found = [getattr(f, side) for f, s in zip(frames, spans) if (s.colspan if which == "c" else s.rowspan).start == index]
        return max(found, default=0)

    lefts, rights = ([most(side, "c", c) for c in range(columns)] for side in ("left", "right"))
    wide = (width - sum(lefts) - sum(rights)) / columns
    for frame in frames:
        frame.slant(wide)
    tops, bottoms = ([most(side, "r", r) for r in range(rows)] for side in ("top", "bottom"))
    tall = max(height - sum(tops) - sum(bottoms), 30 * rows) / sum(ratios)
    outgrown = False
    for frame, span in zip(frames, spans):
        row, column = span.rowspan.start, span.colspan.start
        left = sum(lefts[: column + 1]) + sum(rights[:column]) + column * wide
        top = sum(tops[: row + 1]) + sum(bottoms[:row]) + tall * sum(ratios[:row])
        frame.axes.set_position((left / width, 1 - (top + tall * ratios[row]) / height, wide / width, tall * ratios[row] / height))
        frame.axes.apply_aspect()
        widest = frame.y.widest
        frame.x, frame.y = Side(frame.axes.xaxis), Side(frame.axes.yaxis)
        outgrown = outgrown or frame.y.widest > widest
    return frames, outgrown


def draw_frame(canvas, frame):
    """Grid, axes, ticks, labels, title and legend of a panel."""
    axes, box = frame.axes, frame.axes.bbox
    xs = axes.transData.transform([(place, axes.get_ylim()[0]) for place in frame.x.places])[:, 0] if len(frame.x.places) else []
    ys = axes.transData.transform([(axes.get_xlim()[0], place) for place in frame.y.places])[:, 1] if len(frame.y.places) else []
    lines = [((x, box.y0), (x, box.y1)) for x in xs if "x" in axes.grid_along]
    lines += [((box.x0, y), (box.x1, y)) for y in ys if "y" in axes.grid_along]
    if lines:
        ends = [canvas.flip.transform(line).round().astype(int) for line in lines]
        grid = "".join(f"M{a[0]} {a[1]}" + (f"V{b[1]}" if a[0] == b[0] else f"H{b[0]}") for a, b in ends)
        canvas.parts.insert(0, f'<path class="grid" d="{grid}"/>')
    (left, top), (right, bottom) = (canvas.flip.transform(p).round().astype(int) for p in ((box.x0, box.y1), (box.x1, box.y0)))
    canvas.parts.append(f'<path class="axis" d="M{left} {top}V{bottom}H{right}"/>')
    for x, label in zip(xs, frame.x.labels):
        if label and frame.slanted:
            canvas.text(x + 3, box.y0 - TICKS, label, "end", angle=40)
        elif label:
            canvas.text(x, box.y0 - TICKS, label, "middle")
    for y, label in zip(ys, frame.y.labels):
        if label:
            canvas.text(box.x0 - GAP, y - 0.35 * TEXT, label, "end")
    above = box.y1 + 5
    if frame.y.offset:
        canvas.text(box.x0, above, frame.y.offset)
        above += LINE
    if frame.title:
        canvas.text(box.x0 - frame.left + GAP, above, frame.title)
        above += LINE
    if frame.legend:
        canvas.parts.append('<g class="legend">')
        for number, row in enumerate(reversed(frame.legend)):
            for start, handle in row:
                draw_sample(canvas, handle, GAP + start, above + LINE * number)
        canvas.parts.append("</g>")
    if frame.x.title:
        canvas.text((box.x0 + box.x1) / 2, box.y0 - frame.bottom + 3, frame.x.title, "middle")
    if frame.x.offset:
        canvas.text(box.x1, box.y0 - frame.bottom + 3, frame.x.offset, "end")
    for number, title in enumerate(reversed(frame.y.title.split("\n") if frame.y.title else [])):
        x = box.x0 - frame.y.widest - GAP - 6 - LINE * number
        canvas.text(x, (box.y0 + box.y1) / 2, title, "middle", angle=90)


def draw_sample(canvas, handle, x, y):
    """An entry of a legend: a stroke, a mark or a patch, and its label."""
    middle = y + 0.32 * TEXT
    handle = handle[0] if not hasattr(handle, "get_window_extent") else handle  # of an error bar: its line
    gc = GraphicsContextBase()
    if isinstance(handle, Line2D):
        sample = Line2D([x, x + 19], [middle, middle])
        sample.update_from(handle)
        sample.set_transform(Affine2D())
        sample.set_clip_on(False)
        if sample.get_marker() not in ("", " ", "None", None):
            line = Line2D([x, x + 19], [middle, middle], color=sample.get_color(), linewidth=sample.get_linewidth(), linestyle=sample.get_linestyle())
            line.draw(canvas)
            sample.set_linestyle("none")
            sample.set_data([x + 9.5], [middle])
        sample.draw(canvas)
    elif isinstance(handle, PathCollection):
        gc.set_linewidth(0)
        canvas.draw_path(gc, Path.unit_circle(), Affine2D().scale(2.2).translate(x + 9.5, middle), tuple(handle.get_facecolor()[0]))
    else:
        gc.set_linewidth(handle.get_linewidth() if handle.get_edgecolor()[3] else 0)
        gc.set_foreground(handle.get_edgecolor(), isRGBA=True)
        face = handle.get_facecolor()
        canvas.draw_path(gc, Path.unit_rectangle(), Affine2D().scale(16, 7).translate(x + 2, middle - 3.5), face if face[3] else None)
    canvas.text(x + 24, y, str(handle.get_label()))


def svg_of(drawing, label, hints=()):
    """The drawing as SVG. `hints` are (axes, x, y, text): what the page says of a point under the pointer."""
    width, height = (72 * inches for inches in drawing.get_size_inches())
    canvas = Canvas(width, height)
    for axes in drawing.axes:
        axes.get_xlim()  # settles limits that follow the data
        axes.get_ylim()
    frames = place(drawing, width, height)
    for frame in frames:
        axes = frame.axes
        artists = [*axes.images, *axes.collections, *axes.patches, *axes.lines, *axes.texts]
        for artist in sorted(artists, key=lambda artist: artist.get_zorder()):
            artist.draw(canvas)
        draw_frame(canvas, frame)
    told, before = [], []
    for axes, x, y, text in hints:
        place_of = axes.transData.transform((x, y))
        if np.isfinite(place_of).all():
            left, top = canvas.flip.transform(place_of)
            words = text.split(" ")  # those that stand in the same place of the text before are left out
            told.append(f"{left:.0f},{top:.0f}," + " ".join("" if [word] == before[i : i + 1] else word for i, word in enumerate(words)))
            before = words
    described = escape(label)
    told = f' data-hints="{escape(chr(10).join(told))}"' if told else ""
    body = re.sub(r"(?<=\d)\.0(?=[\" ])", "", "".join(canvas.parts))
    return f'<svg class="plot" viewBox="0 0 {SCALE * width:.0f} {SCALE * height:.0f}" role="img" aria-label="{described}"{told}>{body}</svg>'
