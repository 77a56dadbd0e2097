#include "engine/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "base/error.hpp"
#include "base/stop.hpp"

namespace veriflex::engine {

namespace {

void lead(posix_spawn_file_actions_t& actions, int stream, int to) {
  if (to < 0) {
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  } else if (to != stream) {
    posix_spawn_file_actions_adddup2(&actions, to, stream);
  }
}

}  // namespace

Child::Child(std::vector<std::string> words, const Streams& streams, const std::string& remedy) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  lead(actions, STDOUT_FILENO, streams.out);
  lead(actions, STDERR_FILENO, streams.err);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failed = posix_spawn(&pid_, words[0].c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw OutputError(words[0], fmt::format("cannot be run ({})", std::strerror(failed)), remedy);
  }
  handle_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));  // glibc 2.36 declares it for C alone
  if (handle_ >= 0) return;
  const int why = errno;
  kill(pid_, SIGKILL);
  wait();
  throw OutputError(words[0], fmt::format("cannot be watched ({})", std::strerror(why)), remedy);
}

Child::~Child() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    wait();
  }
  close(handle_);
}

void Child::ask_to_stop() const { kill(pid_, SIGTERM); }

int Child::wait() {
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
  ended_ = true;
  return status;
}

std::vector<bool> wait_for_any(const std::vector<const Child*>& children, bool& asked_to_stop) {
  constexpr int look_again = 200;  // [ms]
  std::vector<pollfd> handles;
  for (const Child* child : children) handles.push_back({child->handle(), POLLIN, 0});
  poll(handles.data(), handles.size(), look_again);
  if (stop::asked() && !asked_to_stop) {
    for (const Child* child : children) child->ask_to_stop();
    asked_to_stop = true;
  }
  std::vector<bool> ended;
  for (const pollfd& handle : handles) ended.push_back((handle.revents & POLLIN) != 0);
  return ended;
}

namespace {

[[noreturn]] void refuse_memory() {
  throw OutputError("memory", "words between programs cannot be handed on", "Free some memory");
}

}  // namespace

FileInMemory::FileInMemory() : file_(memfd_create("veriflex", MFD_CLOEXEC)) {
  if (file_ < 0) refuse_memory();
}

FileInMemory::FileInMemory(const std::string& text) : file_(memfd_create("veriflex", 0)) {
  std::size_t done = 0;
  while (file_ >= 0 && done < text.size()) {
    const ssize_t wrote = write(file_, text.data() + done, text.size() - done);
    if (wrote <= 0) break;
    done += static_cast<std::size_t>(wrote);
  }
  if (file_ >= 0 && done == text.size()) {
    lseek(file_, 0, SEEK_SET);
    return;
  }
  if (file_ >= 0) close(file_);
  refuse_memory();
}

FileInMemory::~FileInMemory() { close(file_); }

std::string FileInMemory::path() const { return fmt::format("/dev/fd/{}", file_); }

std::string FileInMemory::text() const {
  std::string all;
  char piece[4096];
  for (;;) {
    const ssize_t read = pread(file_, piece, sizeof piece, static_cast<off_t>(all.size()));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return all;
    all.append(piece, static_cast<std::size_t>(read));
  }
}

}  // namespace veriflex::engine
