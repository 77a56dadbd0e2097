/// Several neighbouring numbers in one vector register, as the compilers' own vector types.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace veriflex::fluid {

#if defined(__AVX512F__)
constexpr std::size_t register_bytes = 64;
#elif defined(__AVX__)
constexpr std::size_t register_bytes = 32;
#else
constexpr std::size_t register_bytes = 16;
#endif

/// N numbers; one is a plain number.
template <class Real, std::size_t N>
struct Lanes {
  using Type __attribute__((vector_size(N * sizeof(Real)))) = Real;

  static Type load(const Real* from) {
    Type v;
    std::memcpy(&v, from, sizeof v);
    return v;
  }
  static void store(Real* to, const Type& v) { std::memcpy(to, &v, sizeof v); }

  /// Lane l of the result is lane l - 1 of v; lane 0 is the last of v.
  static Type up(const Type& v) { return turn<N - 1>(v, std::make_index_sequence<N>{}); }
  /// Lane l of the result is lane l + 1 of v; the last is lane 0 of v.
  static Type down(const Type& v) { return turn<1>(v, std::make_index_sequence<N>{}); }

  static Real get(const Type& v, std::size_t lane) { return v[lane]; }
  static void set(Type& v, std::size_t lane, Real value) { v[lane] = value; }

 private:
  template <std::size_t By, std::size_t... Lane>
  static Type turn(const Type& v, std::index_sequence<Lane...>) {
    return __builtin_shufflevector(v, v, static_cast<int>((Lane + By) % N)...);
  }
};

template <class Real>
struct Lanes<Real, 1> {
  using Type = Real;
  static Type load(const Real* from) { return *from; }
  static void store(Real* to, Type v) { *to = v; }
  static Type up(Type v) { return v; }
  static Type down(Type v) { return v; }
  static Real get(Type v, std::size_t) { return v; }
  static void set(Type& v, std::size_t, Real value) { v = value; }
};

}  // namespace veriflex::fluid
