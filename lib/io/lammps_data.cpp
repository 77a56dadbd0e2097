#include "io/lammps_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "io/csv.hpp"
#include "io/file.hpp"

namespace veriflex::io {

namespace {

struct Token {
  std::string_view text;
  unsigned column;  // 1-based
};

// A line without its comment.
struct Line {
  unsigned number;
  std::vector<Token> tokens;
  std::string_view comment;  // after the '#', trimmed
};

constexpr std::string_view blanks = " \t\r";

std::vector<Token> tokens_of(std::string_view line) {
  std::vector<Token> tokens;
  for (std::size_t at = line.find_first_not_of(blanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    tokens.push_back({line.substr(at, end - at), static_cast<unsigned>(at + 1)});
    at = line.find_first_not_of(blanks, end);
  }
  return tokens;
}

// All lines but the first, which is a title, and empty ones.
std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  unsigned number = 0;
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    const std::string_view whole = text.substr(0, newline);
    text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
    if (++number == 1) continue;
    const std::size_t hash = whole.find('#');
    std::string_view comment = hash == std::string_view::npos ? std::string_view{} : whole.substr(hash + 1);
    comment.remove_prefix(std::min(comment.find_first_not_of(blanks), comment.size()));
    comment = comment.substr(0, comment.find_last_not_of(blanks) + 1);
    std::vector<Token> tokens = tokens_of(whole.substr(0, hash));
    if (!tokens.empty()) lines.push_back({number, std::move(tokens), comment});
  }
  return lines;
}

// The sections that follow the header. `counted` is the header's word for the number of rows, empty where
// rows are passed over. The first three must be there when they are announced.
constexpr std::size_t needed_sections = 3;
struct SectionKind {
  std::string_view name;
  std::string_view counted;
};
constexpr std::array sections{
    SectionKind{"Atoms", "atoms"},
    SectionKind{"Bonds", "bonds"},
    SectionKind{"Angles", "angles"},
    SectionKind{"Masses", "atom types"},
    SectionKind{"Bond Coeffs", "bond types"},
    SectionKind{"Angle Coeffs", "angle types"},
    SectionKind{"Velocities", ""},
    SectionKind{"Pair Coeffs", ""},
    SectionKind{"PairIJ Coeffs", ""},
    SectionKind{"Dihedral Coeffs", ""},
    SectionKind{"Improper Coeffs", ""},
};

// How many integers stand between an atom's id and its type, and between its type and its position.
struct AtomStyle {
  std::string_view name;
  std::size_t before_type;
  std::size_t after_type;
};
constexpr std::array atom_styles{AtomStyle{"atomic", 0, 0}, AtomStyle{"bond", 1, 0}, AtomStyle{"angle", 1, 0},
                                 AtomStyle{"molecular", 1, 0}, AtomStyle{"full", 1, 1}};

template <class Named, std::size_t n>
std::vector<std::string> names_of(const std::array<Named, n>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) names.emplace_back(one.name);
  return names;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : lines_(lines_of(text)) { data_.file = file; }

  LammpsData read() {
    std::size_t at = 0;
    for (; at < lines_.size() && !starts_section(lines_[at]); ++at) read_header(lines_[at]);
    if (!counts_.contains("atoms")) {
      throw InputError(
          at < lines_.size() ? place(lines_[at]) : Place{data_.file},
          "the header ends without a number of atoms",
          "a LAMMPS data file begins with one title line and then '<number> atoms'; what begins with "
          "a letter is a section",
          "Look whether this is a data file, and begin comments with '#'");
    }
    while (at < lines_.size()) at = read_section(at);
    for (std::size_t i = 0; i < needed_sections; ++i) {
      const SectionKind& kind = sections[i];
      if (count(kind.counted) > 0 && !seen_.contains(kind.name)) {
        throw InputError({data_.file}, fmt::format("section '{}' is missing", kind.name),
                         fmt::format("the header announces {} {}", count(kind.counted), kind.counted),
                         "Add the section or correct the header");
      }
    }
    refer_to_atoms();
    refuse_bonds_across_the_box();
    data_.bond_types = static_cast<int>(count("bond types"));
    data_.angle_types = static_cast<int>(count("angle types"));
    return std::move(data_);
  }

 private:
  static bool starts_with_letter(const Token& token) {
    return std::isalpha(static_cast<unsigned char>(token.text[0])) != 0;
  }
  // A header line begins with a number.
  static bool starts_section(const Line& line) { return starts_with_letter(line.tokens[0]); }

  std::int64_t count(std::string_view what) const {
    const auto found = counts_.find(what);
    return found == counts_.end() ? 0 : found->second;
  }

  Place place(const Line& line, std::size_t token = 0) const {
    return {data_.file, line.number, line.tokens[std::min(token, line.tokens.size() - 1)].column};
  }

  std::int64_t integer(const Line& line, std::size_t token, std::int64_t low, std::int64_t high,
                       std::string_view what) const {
    const std::string_view text = without_plus(line.tokens[token].text);
    std::int64_t value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || stop != text.data() + text.size()) {
      throw InputError(place(line, token), fmt::format("'{}' is not an integer", text),
                       fmt::format("{} is needed here", what), "Correct the row");
    }
    if (value < low || value > high) {
      throw InputError(place(line, token), fmt::format("{} is {}", what, value),
                       fmt::format("it must lie between {} and {}", low, high),
                       "Correct the row or the header");
    }
    return value;
  }

  double number(const Line& line, std::size_t token, std::string_view what) const {
    const std::string_view text = without_plus(line.tokens[token].text);
    double value = 0.0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || stop != text.data() + text.size() || !std::isfinite(value)) {
      throw InputError(place(line, token), fmt::format("'{}' is not a finite number", text),
                       fmt::format("{} is needed here", what), "Correct the row");
    }
    return value;
  }

  void read_header(const Line& line) {
    std::vector<std::string_view> words;
    std::size_t numbers = 0;
    for (const Token& token : line.tokens) {
      const bool is_word = starts_with_letter(token);
      if (is_word) words.push_back(token.text);
      if (!is_word && words.empty()) ++numbers;
    }
    const std::string what = fmt::format("{}", fmt::join(words, " "));
    const auto box = std::array<std::string_view, 4>{"xlo xhi", "ylo yhi", "zlo zhi", "xy xz yz"};
    if (const auto side = std::find(box.begin(), box.end(), what); side != box.end()) {
      read_side(line, numbers, static_cast<std::size_t>(side - box.begin()));
      return;
    }
    // What LAMMPS keeps room for is nothing that a body consists of.
    if (what.starts_with("extra ") && what.ends_with(" per atom") && numbers == 1) return;
    const auto counted = std::array<std::string_view, 10>{
        "atoms",      "bonds",      "angles",      "dihedrals",      "impropers",
        "atom types", "bond types", "angle types", "dihedral types", "improper types"};
    if (std::find(counted.begin(), counted.end(), what) == counted.end() || numbers != 1) {
      throw InputError(
          place(line), fmt::format("'{}' is no line of a header that is known here", what),
          fmt::format("known: {}, extra ... per atom, {}", fmt::join(counted, ", "), fmt::join(box, ", ")),
          "Remove it, or correct the section's name before it");
    }
    if (counts_.contains(what)) {
      throw InputError(place(line), fmt::format("the number of {} is given twice", what), "", "Keep one");
    }
    // Nodes and bonds are numbered by 32 bits.
    counts_[what] = integer(line, 0, 0, 2147483647, "the number of " + what);
    if ((what == "dihedrals" || what == "impropers") && count(what) > 0) {
      throw InputError(place(line), fmt::format("the file has {}", what),
                       "a network here has bonds and angles only", "Leave them out");
    }
  }

  // `lo hi` of an axis; the tilt of a box makes no difference to its extent along the axes.
  void read_side(const Line& line, std::size_t numbers, std::size_t axis) {
    if (axis == 3) return;
    if (numbers != 2) {
      throw InputError(place(line), fmt::format("{} numbers", numbers), "a side of the box has two ends",
                       "Write '<low> <high>' and the names of the ends");
    }
    box_[axis] = number(line, 1, "the high end of the box") - number(line, 0, "the low end of the box");
    if (!(box_[axis] >= 0.0)) {
      throw InputError(place(line), "the box ends before it begins", "its low end comes first",
                       "Exchange the two numbers");
    }
  }

  std::size_t read_section(std::size_t at) {
    const Line& head = lines_[at];
    std::vector<std::string_view> words;
    for (const Token& token : head.tokens) words.push_back(token.text);
    const std::string name = fmt::format("{}", fmt::join(words, " "));
    const auto kind =
        std::find_if(sections.begin(), sections.end(), [&](const SectionKind& k) { return k.name == name; });
    if (kind == sections.end()) {
      const std::string near = nearest_name(name, names_of(sections));
      throw InputError(place(head), fmt::format("unknown section '{}'", name),
                       fmt::format("known: {}", fmt::join(names_of(sections), ", ")),
                       near.empty() ? "Remove it" : fmt::format("Did you mean '{}'?", near));
    }
    if (!seen_.emplace(kind->name, head.number).second) {
      throw InputError(place(head), fmt::format("section '{}' twice", name),
                       fmt::format("the first stands in line {}", seen_[kind->name]), "Keep one");
    }
    std::size_t end = at + 1;
    while (end < lines_.size() && !starts_section(lines_[end])) ++end;
    if (kind->counted.empty()) return end;
    const auto rows = static_cast<std::int64_t>(end - at - 1);
    if (rows != count(kind->counted)) {
      throw InputError(place(head), fmt::format("section '{}' has {} rows", name, rows),
                       fmt::format("the header announces {} {}", count(kind->counted), kind->counted),
                       "Complete the section or correct the header");
    }
    if (name == "Atoms") {
      read_atoms(head, at + 1, end);
    } else if (name == "Bonds") {
      read_connections(data_.bonds, at + 1, end, "bond", "bond types");
    } else if (name == "Masses") {
      read_masses(at + 1, end);
    } else if (name == "Bond Coeffs") {
      read_coefficients(data_.bond_coefficients, head, at + 1, end, "bond types");
    } else if (name == "Angle Coeffs") {
      read_coefficients(data_.angle_coefficients, head, at + 1, end, "angle types");
    } else {
      read_connections(data_.angles, at + 1, end, "angle", "angle types");
    }
    return end;
  }

  void need_fields(const Line& line, std::size_t wanted, std::string_view row) const {
    if (line.tokens.size() == wanted) return;
    throw InputError(place(line), fmt::format("{} fields", line.tokens.size()),
                     fmt::format("a row here is '{}'", row), "Complete or remove the row");
  }

  void read_atoms(const Line& head, std::size_t from, std::size_t to) {
    const auto style = std::find_if(atom_styles.begin(), atom_styles.end(),
                                    [&](const AtomStyle& s) { return s.name == head.comment; });
    if (style == atom_styles.end()) {
      throw InputError(
          place(head),
          head.comment.empty() ? "the atom style is not named"
                               : fmt::format("atom style '{}' is not known", head.comment),
          "it decides which field is which",
          fmt::format("Write 'Atoms # <style>' with one of: {}", fmt::join(names_of(atom_styles), ", ")));
    }
    const std::size_t type = 1 + style->before_type;
    const std::size_t x = type + 1 + style->after_type;
    const std::string row = fmt::format("id {}type {}x y z", style->before_type > 0 ? "molecule " : "",
                                        style->after_type > 0 ? "charge " : "");
    for (std::size_t i = from; i < to; ++i) {
      const Line& line = lines_[i];
      const bool has_images = line.tokens.size() == x + 6;
      if (!has_images) need_fields(line, x + 3, row);
      LammpsAtom atom{integer(line, 0, 1, most, "an atom's id"),
                      static_cast<int>(integer(line, type, 1, count("atom types"), "an atom's type")),
                      {number(line, x, "x"), number(line, x + 1, "y"), number(line, x + 2, "z")}};
      if (style->before_type > 0) integer(line, 1, -most, most, "a molecule's id");
      for (std::size_t image = x + 3; has_images && image < x + 6; ++image) {
        if (integer(line, image, -most, most, "an image flag") != 0) {
          throw InputError(place(line, image), "an image flag is not zero", "there is no periodic box here",
                           "Write unwrapped positions and flags 0 0 0");
        }
      }
      line_of_atom_.emplace_back(atom.id, line.number);
      data_.atoms.push_back(atom);
    }
    sort_and_find_repeated(data_.atoms, line_of_atom_, "atom");
  }

  void read_masses(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const Line& line = lines_[i];
      need_fields(line, 2, "type mass");
      const auto type = static_cast<int>(integer(line, 0, 1, count("atom types"), "an atom's type"));
      const double mass = number(line, 1, "a mass");
      if (!(mass > 0.0)) {
        throw InputError(place(line, 1), fmt::format("the mass of type {} is {}", type, mass),
                         "it must be positive", "Correct the row");
      }
      data_.masses.push_back({type, mass, line.number});
    }
  }

  void read_coefficients(std::vector<LammpsCoefficients>& all, const Line& head, std::size_t from,
                         std::size_t to, std::string_view types) {
    for (std::size_t i = from; i < to; ++i) {
      const Line& line = lines_[i];
      LammpsCoefficients row{static_cast<int>(integer(line, 0, 1, count(types), "a type")),
                             std::string(head.comment),
                             {},
                             line.number};
      std::size_t token = 1;
      if (line.tokens.size() > 1 && starts_with_letter(line.tokens[1])) row.style = line.tokens[token++].text;
      for (; token < line.tokens.size(); ++token) row.values.push_back(number(line, token, "a coefficient"));
      all.push_back(row);
    }
  }

  template <class Connection>
  void read_connections(std::vector<Connection>& all, std::size_t from, std::size_t to, std::string_view what,
                        std::string_view types) {
    constexpr std::size_t atoms = std::tuple_size_v<decltype(Connection::atoms)>;
    std::vector<std::pair<std::int64_t, unsigned>> lines;
    for (std::size_t i = from; i < to; ++i) {
      const Line& line = lines_[i];
      need_fields(line, 2 + atoms, atoms == 2 ? "id type atom atom" : "id type atom apex atom");
      Connection connection{};
      connection.id = integer(line, 0, 1, most, fmt::format("the {}'s id", what));
      connection.type =
          static_cast<int>(integer(line, 1, 1, count(types), fmt::format("the {}'s type", what)));
      for (std::size_t k = 0; k < atoms; ++k)
        connection.atoms[k] = integer(line, 2 + k, 1, most, "an atom's id");
      connection.line = line.number;
      for (std::size_t k = 0; k < atoms; ++k) {
        if (std::count(connection.atoms.begin(), connection.atoms.end(), connection.atoms[k]) > 1) {
          throw InputError(place(line, 2 + k),
                           fmt::format("{} {} names atom {} twice", what, connection.id, connection.atoms[k]),
                           "its atoms must differ", "Correct the row");
        }
      }
      lines.emplace_back(connection.id, line.number);
      all.push_back(connection);
    }
    sort_and_find_repeated(all, lines, what);
  }

  template <class Row>
  void sort_and_find_repeated(std::vector<Row>& rows, std::vector<std::pair<std::int64_t, unsigned>>& lines,
                              std::string_view what) const {
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.id < b.id; });
    std::sort(lines.begin(), lines.end());
    const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
    const auto twice = std::adjacent_find(lines.begin(), lines.end(), same);
    if (twice != lines.end()) {
      throw InputError({data_.file, (twice + 1)->second, 1}, fmt::format("{} {} twice", what, twice->first),
                       fmt::format("the first stands in line {}", twice->second),
                       "Give every row an id of its own");
    }
  }

  // When all sections are read: they may stand in any order.
  void refer_to_atoms() const {
    const auto check = [&](const auto& all, std::string_view what) {
      for (const auto& one : all) {
        for (const std::int64_t id : one.atoms) {
          const auto at =
              std::lower_bound(data_.atoms.begin(), data_.atoms.end(), id,
                               [](const LammpsAtom& a, std::int64_t wanted) { return a.id < wanted; });
          if (at == data_.atoms.end() || at->id != id) {
            throw InputError({data_.file, one.line, 1}, fmt::format("{} {} names atom {}", what, one.id, id),
                             fmt::format("none of the {} atoms has that id", data_.atoms.size()),
                             "Correct the row");
          }
        }
      }
    };
    check(data_.bonds, "bond");
    check(data_.angles, "angle");
  }

  // In a periodic box such a bond would be that to the nearer image. Whether the box is periodic does not
  // stand in the file, and without one the body would be another.
  void refuse_bonds_across_the_box() const {
    const auto position = [&](std::int64_t id) -> const std::array<double, 3>& {
      return std::lower_bound(data_.atoms.begin(), data_.atoms.end(), id,
                              [](const LammpsAtom& a, std::int64_t wanted) { return a.id < wanted; })
          ->position;
    };
    for (const LammpsBond& bond : data_.bonds) {
      const auto& first = position(bond.atoms[0]);
      const auto& second = position(bond.atoms[1]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (box_[axis] <= 0.0 || std::abs(second[axis] - first[axis]) <= 0.5 * box_[axis]) continue;
        throw InputError(
            {data_.file, bond.line, 1},
            fmt::format("bond {} reaches over more than half of the box along {}", bond.id, "xyz"[axis]),
            "it seems to cross a periodic box, which there is none of here",
            "Write unwrapped positions, or a box with room around the body");
      }
    }
  }

  static constexpr std::int64_t most = 1'000'000'000'000'000;

  std::vector<Line> lines_;
  LammpsData data_{};
  std::map<std::string, std::int64_t, std::less<>> counts_;
  std::map<std::string_view, unsigned> seen_;  // section and its line
  std::vector<std::pair<std::int64_t, unsigned>> line_of_atom_;
  std::array<double, 3> box_{};  // its extent along the axes; 0 where the header does not tell  [L]
};

}  // namespace

LammpsData parse_lammps_data(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

LammpsData read_lammps_data(const std::filesystem::path& path) {
  return parse_lammps_data(read_file(path), path.string());
}

std::string write_lammps_data(const LammpsData& data, const std::vector<std::array<double, 3>>& velocities,
                              const std::string& title) {
  std::array<double, 3> low = data.atoms.front().position, high = low;
  std::map<std::int64_t, const LammpsAtom*> by_id;
  for (const LammpsAtom& atom : data.atoms) {
    by_id[atom.id] = &atom;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], atom.position[axis]);
      high[axis] = std::max(high[axis], atom.position[axis]);
    }
  }
  double longest = 1.0;
  for (const LammpsBond& bond : data.bonds) {
    const std::array<double, 3>&a = by_id[bond.atoms[0]]->position, &b = by_id[bond.atoms[1]]->position;
    longest = std::max(longest, std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
  }
  std::string text =
      fmt::format("{}\n\n{} atoms\n{} bonds\n{} angles\n{} atom types\n{} bond types\n{} angle types\n\n",
                  title, data.atoms.size(), data.bonds.size(), data.angles.size(), data.masses.size(),
                  data.bond_types, data.angle_types);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{0} {1} {2}lo {2}hi\n", low[axis] - longest, high[axis] + longest, "xyz"[axis]);
  }
  text += "\nMasses\n\n";
  for (const LammpsMass& mass : data.masses) text += fmt::format("{} {}\n", mass.type, mass.mass);
  text += "\nAtoms # angle\n\n";
  for (const LammpsAtom& atom : data.atoms)
    text += fmt::format("{} 1 {} {}\n", atom.id, atom.type, fmt::join(atom.position, " "));
  text += "\nVelocities\n\n";
  for (std::size_t i = 0; i < data.atoms.size(); ++i)
    text += fmt::format("{} {}\n", data.atoms[i].id, fmt::join(velocities[i], " "));
  const auto add = [&text](const char* name, const auto& all) {
    if (all.empty()) return;
    text += fmt::format("\n{}\n\n", name);
    for (const auto& one : all)
      text += fmt::format("{} {} {}\n", one.id, one.type, fmt::join(one.atoms, " "));
  };
  add("Bonds", data.bonds);
  add("Angles", data.angles);
  return text;
}

}  // namespace veriflex::io
