/// What C libraries make and have to be given back to them.
#pragma once

#include <memory>
#include <type_traits>

namespace veriflex::measures {

/// Calls a library's release by what is held or, where it asks for that, by the address of its handle.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* held) const {
    if constexpr (std::is_invocable_v<decltype(release), T*>) {
      release(held);
    } else {
      release(&held);
    }
  }
};
template <class T, auto release>
using Held = std::unique_ptr<T, Release<release>>;

}  // namespace veriflex::measures
