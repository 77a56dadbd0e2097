/// What accuracy costs: which rows of a sweep are worth their work.
#pragma once

#include "observe/record.hpp"
#include "studies/grid.hpp"

namespace veriflex::studies {

/// What a row gives and takes. Not a number where its run did not come to its end.
struct Priced {
  double error;
  double work;
};

/// The Pareto front: the rows that no other beats, by at most their error for at most their work and less of
/// one of them. Of rows alike the first. By rising work, so that their errors fall: for an error between
/// those of two neighbours the second is the cheapest row that reaches it.
std::vector<std::size_t> front(const std::vector<Priced>& rows);

/// A grid of which every row is priced.
struct PricedGrid {
  std::vector<Axis> axes;
  std::vector<Cell> cells;
  std::vector<Priced> rows;
  observe::Column error, work;  // what they are, without values
};

/// Three records of a study:
///  `<name>_front`: the front, with the settings of its rows;
///  `<name>_settings`: for each value of each axis from which error on to which a setting with it is the
///    cheapest (not a number: for none), and what it costs over the cheapest of all where that is least;
///  `<name>_reached`: for errors of 1e-1, 1e-2, ... the cheapest setting that reaches them, and which single
///    step along an axis from there lowers the error most.
std::vector<observe::Record> front_records(const std::string& name, const PricedGrid& grid);

}  // namespace veriflex::studies
