/// Other programs that this one starts and waits for.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace veriflex::engine {

/// Where a child's words go: a file descriptor of this program, or -1 for nowhere.
struct Streams {
  int out = -1;
  int err = -1;
};

/// A program that runs beside this one, in a process group of its own: what a terminal sends goes to this
/// program, which asks its children. It is killed if this object goes before its end.
class Child {
 public:
  /// `words`: the program's path and its arguments. Throws OutputError, with `remedy`, when it cannot be
  /// started.
  Child(std::vector<std::string> words, const Streams& streams, const std::string& remedy);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Becomes readable when the child ends: for poll().
  int handle() const { return handle_; }
  void ask_to_stop() const;

  /// Waits for its end. As waitpid() gives it.
  int wait();

 private:
  pid_t pid_ = 0;
  int handle_ = -1;
  bool ended_ = false;
};

/// Waits until one of the children ends, or until it is time to look again; where this program is asked to
/// stop it asks them to, once (`asked_to_stop` remembers). Returns which have ended, one entry per child.
std::vector<bool> wait_for_any(const std::vector<const Child*>& children, bool& asked_to_stop);

/// A file in memory.
class FileInMemory {
 public:
  /// Empty, for what one child is to say; other children do not have it.
  FileInMemory();
  /// With text, for children that read it at path(). Throws OutputError when there is no memory for it.
  explicit FileInMemory(const std::string& text);
  ~FileInMemory();
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;

  int descriptor() const { return file_; }
  std::string path() const;
  /// All that stands in it.
  std::string text() const;

 private:
  int file_;
};

}  // namespace veriflex::engine
