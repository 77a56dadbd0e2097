/// Files that a run leaves beside its result. A run does not know where that will be: whoever starts it takes
/// them, or nobody does.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace veriflex::observe {

/// Takes a file: its name and its bytes.
using Attach = std::function<void(const std::string& name, std::string_view bytes)>;

/// While it lives, files that runs leave go to `to`. One at a time.
class Attaching {
 public:
  explicit Attaching(Attach to);
  ~Attaching();
  Attaching(const Attaching&) = delete;
  Attaching& operator=(const Attaching&) = delete;
};

/// Whether somebody takes files, and handing one over.
bool is_attaching();
void attach(const std::string& name, std::string_view bytes);

}  // namespace veriflex::observe
