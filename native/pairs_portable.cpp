// The pair kernels for any processor. GCC and Clang map four lanes onto SSE2, NEON or whatever there is; other compilers get
// plain floats.
#include <cmath>
#include <cstring>

#include "pairs_kernel.hpp"

namespace {

struct Portable {
#ifdef __GNUC__
    typedef float reg __attribute__((vector_size(16)));
    typedef std::int32_t bits __attribute__((vector_size(16)));
    static constexpr int width = 4;
#else
    using reg = float;
    using bits = std::int32_t;
    static constexpr int width = 1;
#endif
    static constexpr int rows = 2;

    static inline reg load(const float *p) { return load_unaligned(p); }
    static inline reg load_unaligned(const float *p) {
        reg v;
        std::memcpy(&v, p, sizeof v);
        return v;
    }
    static inline reg broadcast(float v) { return reg{} + v; }
    static inline void store(float *p, reg v) { store_unaligned(p, v); }
    static inline void store_unaligned(float *p, reg v) { std::memcpy(p, &v, sizeof v); }
    static inline void stream(float *p, reg v) { store_unaligned(p, v); }
    static inline void fence() {}
    static inline reg add(reg a, reg b) { return a + b; }
    static inline reg sub(reg a, reg b) { return a - b; }
    static inline reg mul(reg a, reg b) { return a * b; }
    static inline reg fma(reg a, reg b, reg c) { return c + a * b; }
    static inline reg fnma(reg a, reg b, reg c) { return c - a * b; }
    static inline reg abs(reg a) {
        bits b;
        std::memcpy(&b, &a, sizeof b);
        b &= 0x7fffffff;
        std::memcpy(&a, &b, sizeof a);
        return a;
    }
    static inline reg max(reg a, reg b) { return a > b ? a : b; }
    static inline reg sqrt(reg a) {
        float lanes[width];
        std::memcpy(lanes, &a, sizeof a);
        for (int k = 0; k < width; ++k) lanes[k] = std::sqrt(lanes[k]);
        return load_unaligned(lanes);
    }
    static inline reg exp2(reg t) {
        t = max(t, broadcast(-126.f));
        // adding 1.5 * 2^23 leaves the nearest whole number in the low bits
        const reg magic = broadcast(12582912.f);
        const reg shifted = t + magic;
        const reg f = t - (shifted - magic);
        bits n, magic_bits, result;
        std::memcpy(&n, &shifted, sizeof n);
        std::memcpy(&magic_bits, &magic, sizeof magic_bits);
        reg p = broadcast(kExp2[4]);
        for (int k = 3; k >= 0; --k) p = p * f + kExp2[k];
        p = p * f + 1.f;
        std::memcpy(&result, &p, sizeof result);
        result += (n - magic_bits) * (1 << 23);
        std::memcpy(&p, &result, sizeof p);
        return p;
    }
    static inline void transpose(const float *from, float *to, int stride) {
        for (int c = 0; c < width; ++c)
            for (int r = 0; r < width; ++r) to[c * stride + r] = from[r * stride + c];
    }
};

}  // namespace

constexpr kinesics::Kernels kinesics::kPortable = Pairs<Portable>::kernels("portable");
