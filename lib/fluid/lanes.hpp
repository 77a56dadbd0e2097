/// Several neighbouring numbers in one vector register, as the compilers' own vector types.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace veriflex::fluid {

#if defined(__AVX512F__)
constexpr std::size_t register_bytes = 64;
#elif defined(__AVX__)
constexpr std::size_t register_bytes = 32;
#else
constexpr std::size_t register_bytes = 16;
#endif

/// a b + c, rounded once where the machine can: written out, because a compiler that fuses as it likes may do
/// so in one variant of a loop and not in another, which would then differ in the last bit.
template <class V>
inline V multiply_add(const V& a, const V& b, const V& add) {
#if defined(__FMA__)
  if constexpr (std::is_floating_point_v<V>) {
    if constexpr (sizeof(V) == 8) {
      return __builtin_fma(a, b, add);
    } else {
      return __builtin_fmaf(a, b, add);
    }
  } else {
    constexpr bool is_double = sizeof(a[0]) == 8;
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64 && is_double)
      return (V)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)add);
    if constexpr (sizeof(V) == 64 && !is_double) return (V)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)add);
#endif
    if constexpr (sizeof(V) == 32 && is_double)
      return (V)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)add);
    if constexpr (sizeof(V) == 32 && !is_double) return (V)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)add);
    if constexpr (sizeof(V) == 16 && is_double) return (V)_mm_fmadd_pd((__m128d)a, (__m128d)b, (__m128d)add);
    if constexpr (sizeof(V) == 16 && !is_double) return (V)_mm_fmadd_ps((__m128)a, (__m128)b, (__m128)add);
    if constexpr (sizeof(V) == 8)
      return V{multiply_add(a[0], b[0], add[0]), multiply_add(a[1], b[1], add[1])};
  }
#else
  return a * b + add;
#endif
}

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

  /// Stores past the caches, where the machine can, at an address that the vector's size divides: the line is
  /// not read first. Seen by other threads after finish_stream() only.
  static void stream(Real* to, const Type& v) {
    [[maybe_unused]] constexpr bool is_double = sizeof(Real) == 8;
#if defined(__AVX512F__)
    if constexpr (sizeof v == 64 && is_double) return _mm512_stream_pd(to, (__m512d)v);
    if constexpr (sizeof v == 64 && !is_double) return _mm512_stream_ps(to, (__m512)v);
#endif
#if defined(__AVX__)
    if constexpr (sizeof v == 32 && is_double) return _mm256_stream_pd(to, (__m256d)v);
    if constexpr (sizeof v == 32 && !is_double) return _mm256_stream_ps(to, (__m256)v);
#endif
#if defined(__SSE2__)
    if constexpr (sizeof v == 16 && is_double) return _mm_stream_pd(to, (__m128d)v);
    if constexpr (sizeof v == 16 && !is_double) return _mm_stream_ps(to, (__m128)v);
#endif
    store(to, v);
  }
  static void finish_stream() {
#if defined(__SSE2__)
    _mm_sfence();
#endif
  }

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
  static void stream(Real* to, Type v) { *to = v; }
  static void finish_stream() {}
  static Type up(Type v) { return v; }
  static Type down(Type v) { return v; }
  static Real get(Type v, std::size_t) { return v; }
  static void set(Type& v, std::size_t, Real value) { v = value; }
};

}  // namespace veriflex::fluid
