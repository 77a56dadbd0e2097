#include "engine/checkpoint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/say.hpp"
#include "engine/case.hpp"
#include "engine/only.hpp"
#include "engine/result.hpp"
#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t schema = 1;
constexpr double share = 0.01;  // of a run that checkpoints may take

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double cpu_seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Number of the first line in which two texts differ.
std::size_t first_difference(const std::string& a, const std::string& b) {
  const auto at = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  return 1 + static_cast<std::size_t>(std::count(a.begin(), at, '\n'));
}

}  // namespace

Checkpoints::Checkpoints(fs::path file, const Case& c, bool resume)
    : file_(std::move(file)), text_(c.text), settings_(fmt::format("{}", fmt::join(c.overrides, ", "))) {
  std::error_code unknown;
  if (!resume) return;
  if (!fs::exists(file_, unknown)) {
    complain("{}: there is no checkpoint to go on from: the run begins at its start", file_.string());
    return;
  }
  const io::Hdf5File& found = earlier_.emplace(file_, io::checkpoint_seal);
  const auto refuse = [this](const std::string& why) {
    throw InputError({file_.string()}, "is a checkpoint of another run", why,
                     "Run without --resume to begin anew, which replaces it, or choose another --out");
  };
  if (found.integer("/", "schema") != schema) refuse("it was written by another version of this program");
  const std::string text = only(found.texts("/case"), file_.string(), "/case");
  if (text != text_) {
    refuse(fmt::format("the case file has changed since, from line {} on", first_difference(text, text_)));
  }
  const std::string settings = found.attribute("/", "settings");
  const auto words = [](const std::string& all) { return all.empty() ? "nothing" : all; };
  if (settings != settings_) {
    refuse(fmt::format("it was changed by --set {}, this run by {}", words(settings), words(settings_)));
  }
  const std::string maker = found.attribute("/", "program");
  if (maker != program()) {
    refuse(fmt::format("it was made by program {}, this is {}, whose numbers may differ", maker, program()));
  }
}

void Checkpoints::resumed(std::int64_t step, Cost& cost) {
  const work::Counts now = work::done();
  const auto earlier = [&](const char* name) {
    const std::string at = fmt::format("/so_far/{}", name);
    return only(earlier_->numbers(at), file_.string(), at);
  };
  for (const work::Field& field : work::fields) {
    const auto then = static_cast<std::uint64_t>(earlier_->integer("/so_far", field.name));
    // Modulo 2^64, as tallies add up.
    work::add(work::mine().*field.tally, then - (now.*field.count - before_.*field.count));
  }
  wall_before_ = earlier("wall_seconds");
  cpu_before_ = earlier("cpu_seconds");
  cost.add({fmt::format("until step {}, before it was resumed", step), wall_before_, cpu_before_});
  earlier_.reset();
}

bool Checkpoints::is_due(double seconds) const {
  const double since = seconds_since(last_);
  return since >= seconds && since * share >= took_;
}

void Checkpoints::write(std::int64_t step, const std::function<void(io::Hdf5Image&)>& put) {
  const auto start = Clock::now();
  try {
    io::Hdf5Image image;
    put(image);
    say_whose(image, step);
    io::write_file(file_, image.bytes(io::checkpoint_seal));
  } catch (const std::exception& error) {
    if (!has_complained_) {
      complain("{}: no checkpoint of step {} ({}). The run goes on without", file_.string(), step,
               error.what());
    }
    has_complained_ = true;
  }
  took_ = seconds_since(start);
  last_ = Clock::now();
}

void Checkpoints::say_whose(io::Hdf5Image& image, std::int64_t step) const {
  image.attribute("/", "format", io::checkpoint_seal);
  image.attribute("/", "schema", schema);
  image.attribute("/", "step", step);
  image.attribute("/", "settings", settings_);
  image.attribute("/", "program", program());
  image.text("/case", text_);
  image.numbers("/so_far/wall_seconds", std::vector{wall_before_ + seconds_since(began_)});
  image.numbers("/so_far/cpu_seconds", std::vector{cpu_before_ + cpu_seconds_since(cpu_began_)});
  const work::Counts now = work::done();
  for (const work::Field& field : work::fields) {
    image.attribute("/so_far", field.name,
                    static_cast<std::int64_t>(now.*field.count - before_.*field.count));
  }
}

void Checkpoints::remove() const {
  std::error_code gone;
  fs::remove(file_, gone);
}

fs::path checkpoint_path(const Case& c, const fs::path& folder) {
  return folder / (c.name() + ".checkpoint");
}

}  // namespace veriflex::engine
