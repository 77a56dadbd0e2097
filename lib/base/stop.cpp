#include "base/stop.hpp"

#include <fmt/format.h>

namespace veriflex::stop {

std::atomic<int> signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);  // it is written by a signal handler

namespace {

std::atomic<bool> thrown = false;
std::atomic<bool> held = false;
std::atomic<int> waiting = 0;  // signal that came while it was

constexpr std::array asking{SIGINT, SIGTERM, SIGHUP};

extern "C" void ask_to_stop(int number) {
  std::atomic<int>& asks = held ? waiting : signal;
  if (asks.exchange(number) == 0) return;
  ::signal(number, SIG_DFL);
  raise(number);
}

}  // namespace

bool was_thrown() { return thrown; }

void forget() { thrown = false; }

std::string reason() {
  switch (signal) {
    case SIGINT:
      return "interrupted by SIGINT";
    case SIGHUP:
      return "interrupted by SIGHUP: the terminal has gone";
    default:
      return "interrupted by SIGTERM";
  }
}

void here(const char* what, std::int64_t number) {
  thrown = true;
  throw Stopped(fmt::format("{} at {} {}", reason(), what, number));
}

Held::Held() { held = true; }

Held::~Held() {
  held = false;
  if (const int number = waiting.exchange(0); number != 0) signal = number;
}

Handlers::Handlers() {
  for (std::size_t i = 0; i < asking.size(); ++i) {
    sigaction(asking[i], nullptr, &earlier_[i]);
    if (earlier_[i].sa_handler == SIG_IGN) continue;
    struct sigaction ask {};
    ask.sa_handler = ask_to_stop;
    ask.sa_flags = SA_RESTART;
    sigaction(asking[i], &ask, nullptr);
  }
}

Handlers::~Handlers() {
  for (std::size_t i = 0; i < asking.size(); ++i) sigaction(asking[i], &earlier_[i], nullptr);
}

}  // namespace veriflex::stop
