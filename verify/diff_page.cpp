#include <fmt/format.h>

#include "diff_runs.hpp"

namespace veriflex {

namespace {

const std::string head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>veriflex diff</title>
<meta name="viewport" content="width=device-width">
<style>
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 80rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
td, th { padding: .15rem .8rem .15rem 0; text-align: left; vertical-align: top; }
thead th { border-bottom: 1px solid; }
summary { cursor: pointer; font-weight: 600; margin: 1rem 0 .4rem; }
.worse { border-left: .3rem solid #c33; padding-left: .8rem; }
.fine { border-left: .3rem solid #393; padding-left: .8rem; }
</style></head><body>
)";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string side(const std::string& name, const DiffSide& side) {
  std::string text = fmt::format("<tr><th>{}</th><td>{}</td><td>{} results</td><td>", name,
                                 escaped(side.where), side.results);
  for (const std::string& maker : side.made_by) text += escaped(maker) + "<br>";
  return text + "</td></tr>\n";
}

std::string table(const DiffTable& table) {
  std::string text = fmt::format(
      "<details open><summary>{} ({})</summary>\n<table><thead><tr><th>case</th><th>what</th><th>before</th>"
      "<th>after</th><th>change</th></tr></thead><tbody>\n",
      escaped(table.title), table.rows.size());
  for (const DiffRow& row : table.rows) {
    text += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escaped(row.id),
                        escaped(row.what), escaped(row.before), escaped(row.after), escaped(row.change));
  }
  return text + "</tbody></table></details>\n";
}

}  // namespace

std::string html_of(const Diff& diff) {
  std::string text = head + "<h1>Two runs</h1>\n<table>" + side("before", diff.before) +
                     side("after", diff.after) + "</table>\n";
  text += fmt::format("<p>{}.</p>\n", escaped(summary_of(diff)));
  if (!diff.difference.worse.empty()) {
    text += "<div class=\"worse\"><h2>Worse</h2><ul>\n";
    for (const std::string& one : diff.difference.worse) text += fmt::format("<li>{}</li>\n", escaped(one));
    text += "</ul></div>\n";
  } else {
    text += fmt::format("<p class=\"fine\">{}</p>\n",
                        diff.is_same() ? "Same, bit for bit, but for times." : "Nothing is worse.");
  }
  for (const DiffTable& one : tables_of(diff.difference)) text += table(one);
  return text + "</body></html>\n";
}

}  // namespace veriflex
