#include "io/document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

namespace veriflex::io {

namespace {

using Overridden = std::map<const toml::node*, std::string>;  // what came from --set, with its text

}  // namespace

struct Table::Node {
  std::shared_ptr<const toml::table> document;  // keeps the nodes alive
  const toml::table* table;
  std::string file;
  std::string name;  // dotted path of this table, empty at the top
  std::shared_ptr<const Overridden> overridden;
  std::shared_ptr<const Synonyms> synonyms;
  std::set<std::string, std::less<>> read;
  std::set<std::string, std::less<>> asked;  // keys somebody knows, for suggestions
  std::vector<std::shared_ptr<Node>> below;
  bool abandoned = false;
};

namespace {

std::string type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

Place place_of(const toml::node& node, const Table::Node& in) {
  if (const auto set = in.overridden->find(&node); set != in.overridden->end()) return {set->second};
  return {in.file, node.source().begin.line, node.source().begin.column};
}

// What `key` names inside a table, or `0`, `1`, ... inside an array; null when there is no such thing.
template <class Node>  // toml::node, const or not
Node* entry(Node& in, const std::string& key) {
  if (auto* table = in.as_table()) return table->get(key);
  auto* array = in.as_array();
  const bool is_index =
      !key.empty() && key.find_first_not_of("0123456789") == std::string::npos && key.size() < 6;
  return array != nullptr && is_index ? array->get(std::stoul(key)) : nullptr;
}

// The end of the TOML string that begins at `start`, or of the line or text that it lacks one on.
std::size_t end_of_string(std::string_view text, std::size_t start) {
  const char quote = text[start];
  const std::string triple(3, quote);
  const bool multi_line = text.substr(start, 3) == triple;
  std::size_t at = start + (multi_line ? 3 : 1);
  while (at < text.size()) {
    if (multi_line ? text.substr(at, 3) == triple : text[at] == quote) return at + (multi_line ? 3 : 1);
    if (!multi_line && text[at] == '\n') return at;
    at += quote == '"' && text[at] == '\\' ? 2 : 1;
  }
  return text.size();
}

// toml++ bounds the nesting of values, but not of dotted keys, each part of which takes some of the stack.
void refuse_deep_keys(std::string_view text, const std::string& file) {
  constexpr int deepest = 16;
  unsigned line = 1;
  int dots = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      const std::size_t end = end_of_string(text, at);
      line += static_cast<unsigned>(std::count(text.begin() + static_cast<std::ptrdiff_t>(at),
                                               text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      at = end;
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '\n') ++line;
    if (c == '\n' || std::string_view("=,[]{}").find(c) != std::string_view::npos) dots = 0;
    if (c == '.' && ++dots >= deepest) {
      throw InputError({file, line, 1}, fmt::format("a key of more than {} parts", deepest),
                       "no table is nested that deep", "Shorten it");
    }
    ++at;
  }
}

// All that stands in `node` comes from `setting`.
void mark(const toml::node& node, const std::string& setting, Overridden& overridden) {
  overridden.insert_or_assign(&node, "--set " + setting);
  if (const toml::table* table = node.as_table()) {
    for (const auto& [unused, value] : *table) mark(value, setting, overridden);
  } else if (const toml::array* array = node.as_array()) {
    for (const toml::node& value : *array) mark(value, setting, overridden);
  }
}

bool is_index(const std::string& part) {
  return !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
}

// A dotted path with each part under the name that readers know.
std::string read_as(const std::string& path, const Synonyms& synonyms) {
  if (!synonyms) return path;
  std::string all, table;
  for (std::size_t start = 0; start <= path.size();) {
    const std::size_t dot = std::min(path.find('.', start), path.size());
    std::string part = path.substr(start, dot - start);
    if (const std::string_view key = synonyms(table, part); !key.empty()) part = key;
    all += (start == 0 ? "" : ".") + part;
    if (!is_index(part)) table = part;
    start = dot + 1;
  }
  return all;
}

// Puts what stands under another name under the key that it means, in a table and those below. `place` says
// where a value was written.
void resolve(toml::node& node, const std::string& name, const Synonyms& synonyms,
             const std::function<Place(const toml::node&)>& place) {
  if (toml::array* array = node.as_array()) {
    for (toml::node& item : *array) resolve(item, name, synonyms, place);
  }
  toml::table* table = node.as_table();
  if (table == nullptr) return;
  std::vector<std::pair<std::string, std::string>> found;  // word and key
  for (const auto& [word, unused] : *table) {
    if (const std::string_view key = synonyms(name, word.str()); !key.empty())
      found.emplace_back(word.str(), key);
  }
  for (const auto& [word, key] : found) {
    if (const toml::node* other = table->get(key)) {
      throw InputError(place(*table->get(word)), fmt::format("both '{}' and '{}'", key, word),
                       fmt::format("they are two names of one parameter, the other stands at {}",
                                   to_string(place(*other))),
                       "Keep one");
    }
    table->insert_or_assign(key, std::move(*table->get(word)));
    table->erase(word);
  }
  for (auto&& [key, value] : *table) resolve(value, std::string(key.str()), synonyms, place);
}

// The table that a path of --set needs and the document lacks: a key of a table, or the next `[[name]]`.
toml::node* added_table(toml::node& in, const std::string& key) {
  if (toml::table* table = in.as_table(); table != nullptr && !key.empty()) {
    return &table->insert_or_assign(key, toml::table{}).first->second;
  }
  toml::array* array = in.as_array();
  if (array == nullptr || !array->is_array_of_tables() || key != std::to_string(array->size()))
    return nullptr;
  return &array->emplace_back(toml::table{});
}

// toml++ takes a number that it lacks the memory to read for none, as if the text were wrong: what is right
// the second time was right.
toml::table parsed_twice(const std::string& text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error&) {
    return toml::parse(text, file);
  }
}

void apply_override(toml::table& document, const std::string& setting, const std::string& file,
                    const Synonyms& synonyms, Overridden& overridden) {
  const auto bad = [&](const std::string& problem, const std::string& why, const std::string& suggestion) {
    throw InputError({}, fmt::format("--set {}: {}", setting, problem), why, suggestion);
  };
  refuse_deep_keys(setting, "");
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    bad("not of the form key=value", "", "Write --set bond.epsilon=2.0");
  const std::string path = read_as(setting.substr(0, equals), synonyms);
  const std::string value = setting.substr(equals + 1);
  const bool removes = value.find_first_not_of(" \t") == std::string::npos;

  toml::table parsed;
  try {
    if (!removes) parsed = parsed_twice("value = " + value, "");
  } catch (const toml::parse_error&) {
    parsed = toml::table{{"value", value}};  // a bare word is text
  }
  if (!removes && parsed.size() != 1)
    bad("the value is more than one TOML value", "", "Set one key at a time");

  toml::node* at = &document;
  std::string last = path, table_name;
  for (std::size_t dot = last.find('.'); dot != std::string::npos; dot = last.find('.')) {
    const std::string key = last.substr(0, dot);
    last = last.substr(dot + 1);
    if (!is_index(key)) table_name = key;
    toml::node* next = entry(*at, key);
    if (next == nullptr) {
      if (!removes) next = added_table(*at, key);
      if (next == nullptr) {
        bad(fmt::format("{} has no '{}'", file, key),
            "a table can be added to a table or behind the last of "
            "[[...]]",
            "Look at the case file for its tables");
      }
      mark(*next, setting, overridden);
    }
    at = next;
  }
  if (synonyms && !removes) {
    resolve(*parsed.get("value"), is_index(last) ? table_name : last, synonyms,
            [&](const toml::node&) { return Place{"--set " + setting}; });
  }
  if (toml::array* array = at->as_array(); array != nullptr && entry(*at, last) != nullptr) {
    const auto place = array->cbegin() + static_cast<std::ptrdiff_t>(std::stoul(last));
    if (removes) {
      array->erase(place);
      return;
    }
    array->replace(place, std::move(*parsed.get("value")));
    mark(*array->get(std::stoul(last)), setting, overridden);
    return;
  }
  toml::table* table = at->as_table();
  if (table == nullptr || last.empty()) {
    bad(fmt::format("'{}' is not inside a table of {}", path, file), "", "Look at the case file");
  }
  if (removes) {
    if (table->erase(last) == 0)
      bad(fmt::format("{} has no '{}'", file, path), "it is to be removed", "Look at the case file");
    return;
  }
  table->insert_or_assign(last, std::move(*parsed.get("value")));
  mark(*table->get(last), setting, overridden);
}

// The node of a table below `parent`, the same one however often it is asked for.
std::shared_ptr<Table::Node> child(Table::Node& parent, const toml::table& table, const std::string& name) {
  for (const auto& known : parent.below) {
    if (known->table == &table) return known;
  }
  auto node = std::make_shared<Table::Node>();
  node->document = parent.document;
  node->table = &table;
  node->file = parent.file;
  node->name = parent.name.empty() ? name : parent.name + "." + name;
  node->overridden = parent.overridden;
  node->synonyms = parent.synonyms;
  parent.below.push_back(node);
  return node;
}

const toml::node* find(Table::Node& in, const std::string& key) {
  in.asked.insert(key);
  const toml::node* node = in.table->get(key);
  if (node != nullptr) in.read.insert(key);
  return node;
}

const toml::node& need(const Table& of, Table::Node& in, const std::string& key) {
  const toml::node* node = find(in, key);
  if (node == nullptr) {
    std::vector<std::string> unread;
    for (const auto& [name, unused] : *in.table) {
      if (!in.asked.contains(name.str())) unread.emplace_back(name.str());
    }
    const std::string near = nearest_name(key, unread);
    const std::string where = in.name.empty() ? "the file" : fmt::format("[{}]", in.name);
    throw InputError(near.empty() ? of.place() : of.place(near), fmt::format("{} lacks '{}'", where, key),
                     "it has no default",
                     near.empty() ? "Add it" : fmt::format("Is '{}' a misspelling of it?", near));
  }
  return *node;
}

double as_number(const Table& in, const std::string& key, const toml::node& node, bool infinity_too) {
  const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value && node.is_integer()) {
    in.fail(key, fmt::format("'{}' is {}", key, node.as_integer()->get()), "no double is that integer",
            "Write it with a point or an exponent, like 9.2e18");
  }
  if (!value)
    in.fail(key, fmt::format("'{}' is {}", key, type_name(node)), "a number is needed",
            "Write it without quotes, like 1.5e-3");
  if (std::isnan(*value) || (std::isinf(*value) && !(infinity_too && *value > 0.0))) {
    in.fail(key, fmt::format("'{}' is {}", key, *value), "a finite number is needed", "Give a finite value");
  }
  return *value;
}

std::string shown_node(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return toml_text(number->get());
  std::ostringstream text;
  node.visit([&text](const auto& value) { text << value; });
  return text.str();
}

const toml::array& as_array(const Table& in, const std::string& key, const toml::node& node) {
  if (const toml::array* array = node.as_array()) return *array;
  in.fail(key, fmt::format("'{}' is {}", key, type_name(node)), "an array is needed",
          "Write it in brackets: [...]");
}

}  // namespace

bool Table::has(const std::string& key) const {
  node_->asked.insert(key);
  return node_->table->contains(key);
}

bool Table::has_list(const std::string& key) const { return has(key) && node_->table->get(key)->is_array(); }

bool Table::has_text(const std::string& key) const { return has(key) && node_->table->get(key)->is_string(); }

double Table::number(const std::string& key) const {
  return as_number(*this, key, need(*this, *node_, key), false);
}

double Table::number_or_infinity(const std::string& key) const {
  return as_number(*this, key, need(*this, *node_, key), true);
}

std::int64_t Table::integer(const std::string& key, std::int64_t min, std::int64_t max) const {
  const toml::node& node = need(*this, *node_, key);
  const std::optional<std::int64_t> value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
  if (!value)
    fail(key, fmt::format("'{}' is {}", key, type_name(node)), "an integer is needed",
         "Write it without point and quotes");
  if (*value < min || *value > max) {
    fail(key, fmt::format("'{}' is {}", key, *value), fmt::format("it must lie between {} and {}", min, max),
         "Choose a value in that range");
  }
  return *value;
}

bool Table::flag(const std::string& key) const {
  const toml::node& node = need(*this, *node_, key);
  const std::optional<bool> value = node.is_boolean() ? node.value<bool>() : std::nullopt;
  if (!value)
    fail(key, fmt::format("'{}' is {}", key, type_name(node)), "true or false is needed",
         "Write it without quotes");
  return *value;
}

std::string Table::text(const std::string& key) const {
  const toml::node& node = need(*this, *node_, key);
  const std::optional<std::string> value = node.is_string() ? node.value<std::string>() : std::nullopt;
  if (!value)
    fail(key, fmt::format("'{}' is {}", key, type_name(node)), "text is needed", "Write it in quotes");
  if (value->empty()) fail(key, fmt::format("'{}' is empty", key), "it is shown to the reader", "Fill it in");
  if (value->find('\0') != std::string::npos) {
    fail(key, fmt::format("'{}' holds a zero byte", key), "a result file could not keep what follows it",
         "Remove it");
  }
  return *value;
}

std::vector<double> Table::numbers(const std::string& key) const {
  std::vector<double> values;
  for (const toml::node& item : as_array(*this, key, need(*this, *node_, key))) {
    values.push_back(as_number(*this, key, item, false));
  }
  return values;
}

std::vector<double> Table::numbers_or_none(const std::string& key) const {
  std::vector<double> values;
  for (const toml::node& item : as_array(*this, key, need(*this, *node_, key))) {
    const auto* written = item.as_floating_point();
    values.push_back(written != nullptr ? written->get() : as_number(*this, key, item, false));
  }
  return values;
}

std::vector<std::int64_t> Table::integers(const std::string& key) const {
  std::vector<std::int64_t> values;
  for (const toml::node& item : as_array(*this, key, need(*this, *node_, key))) {
    const std::optional<std::int64_t> value = item.is_integer() ? item.value<std::int64_t>() : std::nullopt;
    if (!value)
      fail(key, fmt::format("'{}' holds {}", key, type_name(item)), "integers are needed",
           "Write them like [4, 4, 12]");
    values.push_back(*value);
  }
  return values;
}

std::vector<std::string> Table::texts(const std::string& key) const {
  std::vector<std::string> values;
  for (const toml::node& item : as_array(*this, key, need(*this, *node_, key))) {
    const std::optional<std::string> value = item.is_string() ? item.value<std::string>() : std::nullopt;
    if (!value || value->empty())
      fail(key, fmt::format("'{}' holds {}", key, value ? "empty text" : type_name(item)), "texts are needed",
           "Write them in quotes");
    if (value->find('\0') != std::string::npos) {
      fail(key, fmt::format("'{}' holds a zero byte", key), "a result file could not keep what follows it",
           "Remove it");
    }
    values.push_back(*value);
  }
  if (values.size() > longest_list) {
    fail(key, fmt::format("'{}' holds {} texts", key, values.size()),
         fmt::format("a result file keeps {}", longest_list), "Shorten it");
  }
  return values;
}

Table Table::table(const std::string& key) const {
  const toml::node& node = need(*this, *node_, key);
  if (!node.is_table())
    fail(key, fmt::format("'{}' is {}", key, type_name(node)), "a table is needed",
         node_->name.empty() ? fmt::format("Write [{}] and its keys below", key)
                             : fmt::format("Write {} = {{}}, its keys between the braces", key));
  return Table(child(*node_, *node.as_table(), key));
}

std::vector<Table> Table::tables(const std::string& key) const {
  std::vector<Table> all;
  const toml::node* node = find(*node_, key);
  if (node == nullptr) return all;
  for (const toml::node& item : as_array(*this, key, *node)) {
    if (!item.is_table())
      fail(key, fmt::format("'{}' holds {}", key, type_name(item)), "tables are needed",
           node_->name.empty() ? fmt::format("Write [[{}]] before each", key)
                               : fmt::format("Write {} = [{{}}], the keys of each between its braces", key));
    all.emplace_back(child(*node_, *item.as_table(), fmt::format("{}.{}", key, all.size())));
  }
  return all;
}

std::optional<double> Table::number_if(const std::string& key) const {
  return has(key) ? std::optional(number(key)) : std::nullopt;
}

double Table::number(const std::string& key, double otherwise) const {
  return has(key) ? number(key) : otherwise;
}

std::string Table::text(const std::string& key, const std::string& otherwise) const {
  return has(key) ? text(key) : otherwise;
}

bool Table::flag(const std::string& key, bool otherwise) const { return has(key) ? flag(key) : otherwise; }

std::string Table::choice(const std::string& key, const std::vector<std::string>& allowed) const {
  const std::string value = text(key);
  for (const std::string& one : allowed) {
    if (value == one) return value;
  }
  const std::string near = nearest_name(value, allowed);
  fail(key, fmt::format("unknown {} '{}'", key, value), fmt::format("known: {}", fmt::join(allowed, ", ")),
       near.empty() ? "Choose one of these" : fmt::format("Did you mean '{}'?", near));
}

std::vector<std::string> Table::keys() const {
  std::vector<std::string> names;
  for (const auto& [name, unused] : *node_->table) names.emplace_back(name.str());
  return names;
}

std::vector<Table::Entry> Table::entries() const {
  std::vector<Entry> all;
  const std::function<void(const toml::table&, const std::string&)> add = [&](const toml::table& table,
                                                                              const std::string& before) {
    for (const auto& [name, value] : table) {
      const std::string path = before + std::string(name.str());
      all.push_back({path, value.value<std::string>(), place_of(value, *node_)});
      if (const toml::table* below = value.as_table()) add(*below, path + ".");
      if (!value.is_array_of_tables()) continue;
      for (const toml::node& item : *value.as_array()) add(*item.as_table(), path + "[].");
    }
  };
  add(*node_->table, "");
  return all;
}

Place Table::place() const { return place_of(*node_->table, *node_); }

Place Table::place(const std::string& key) const {
  const toml::node* node = node_->table->get(key);
  if (node == nullptr) return place();
  return place_of(*node, *node_);
}

void Table::fail(const std::string& key, const std::string& problem, const std::string& why,
                 const std::string& suggestion) const {
  throw InputError(place(key), problem, why, suggestion);
}

std::optional<std::string> Table::shown(const std::string& path) const {
  const toml::node* at = node_->table;
  const std::string known = read_as(path, *node_->synonyms);
  for (std::size_t start = 0; at != nullptr && start <= known.size();) {
    const std::size_t dot = std::min(known.find('.', start), known.size());
    at = entry(*at, known.substr(start, dot - start));
    start = dot + 1;
  }
  if (at == nullptr) return std::nullopt;
  return shown_node(*at);
}

std::string Table::shown_value(const std::string& key) const { return shown_node(need(*this, *node_, key)); }

std::vector<std::string> Table::shown_values(const std::string& key) const {
  std::vector<std::string> all;
  for (const toml::node& item : as_array(*this, key, need(*this, *node_, key)))
    all.push_back(shown_node(item));
  return all;
}

std::vector<InputError> Table::unknown_keys() const {
  std::vector<InputError> all;
  if (node_->abandoned) return all;
  for (const auto& [name, value] : *node_->table) {
    const std::string key{name.str()};
    if (node_->read.contains(key)) continue;
    const std::vector<std::string> known(node_->asked.begin(), node_->asked.end());
    const std::string near = nearest_name(key, known);
    const std::string where = node_->name.empty() ? "the top level" : fmt::format("[{}]", node_->name);
    all.emplace_back(place(key), fmt::format("unknown key '{}' at {}", key, where), "nothing reads it",
                     near.empty() ? fmt::format("Keys known here: {}", fmt::join(known, ", "))
                                  : fmt::format("Did you mean '{}'?", near));
  }
  for (const auto& node : node_->below) {
    for (InputError& error : Table(node).unknown_keys()) all.push_back(std::move(error));
  }
  return all;
}

void Table::abandon() const { node_->abandoned = true; }

void Table::finish() const {
  const std::vector<InputError> unknown = unknown_keys();
  if (!unknown.empty()) throw unknown.front();
}

std::vector<std::string> Table::asked() const {
  std::set<std::string> all(node_->asked.begin(), node_->asked.end());
  for (const auto& node : node_->below) {
    std::string name = node->name.substr(node_->name.empty() ? 0 : node_->name.size() + 1);
    const std::size_t dot = name.find('.');
    if (dot != std::string::npos && name.find_first_not_of("0123456789", dot + 1) == std::string::npos) {
      name.replace(dot, std::string::npos, "[]");
    }
    for (const std::string& key : Table(node).asked()) all.insert(name + "." + key);
  }
  return {all.begin(), all.end()};
}

std::string toml_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string toml_text(double number) {
  std::string text = fmt::format("{}", number);
  if (std::isfinite(number) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

Table parse_document(const std::string& text, const std::string& file,
                     const std::vector<std::string>& overrides, const Synonyms& synonyms) {
  refuse_deep_keys(text, file);
  auto document = std::make_shared<toml::table>();
  try {
    *document = parsed_twice(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError({file, error.source().begin.line, error.source().begin.column}, "not valid TOML",
                     std::string(error.description()), "Mend the line");
  }
  auto top = std::make_shared<Table::Node>();
  if (synonyms) {
    resolve(*document, "", synonyms, [&](const toml::node& node) {
      return Place{file, node.source().begin.line, node.source().begin.column};
    });
  }
  Overridden overridden;
  for (const std::string& setting : overrides) apply_override(*document, setting, file, synonyms, overridden);
  top->synonyms = std::make_shared<const Synonyms>(synonyms);
  top->overridden = std::make_shared<const Overridden>(std::move(overridden));
  top->document = document;
  top->table = document.get();
  top->file = file;
  return Table(top);
}

}  // namespace veriflex::io
