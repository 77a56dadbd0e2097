"""Axes without ticks, spines and clip paths of their own: `svg` draws what stands around the data, and making ticks that nobody draws would be
half of the time of a figure."""

from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis


class NoTick:
    """Stands for a tick: whatever is asked of it does nothing."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *_, **__):
        return self


class Unticked:
    def _get_tick(self, major):
        return NoTick()


class X(Unticked, XAxis):
    pass


class Y(Unticked, YAxis):
    pass


class Panel(Axes):
    """Where a figure shows data; `grid_along` says across which axes there are lines, `legend_handles` what the legend names."""

    def __init__(self, *arguments, **options):
        self.grid_along = {"x", "y"}
        self.legend_handles = []
        super().__init__(*arguments, **options)

    def _init_axis(self):
        self.xaxis, self.yaxis = X(self), Y(self)
        for side, axis in (("bottom", self.xaxis), ("top", self.xaxis), ("left", self.yaxis), ("right", self.yaxis)):
            self.spines[side].register_axis(axis)
        self._update_transScale()
