// The pair kernels for processors with AVX-512 F and DQ.
#include <immintrin.h>

#include "pairs_kernel.hpp"

namespace {

struct Avx512 {
    using reg = __m512;
    static constexpr int width = 16;
    static constexpr int rows = 8;
    static inline reg load(const float *p) { return _mm512_load_ps(p); }
    static inline reg load_unaligned(const float *p) { return _mm512_loadu_ps(p); }
    static inline reg broadcast(float v) { return _mm512_set1_ps(v); }
    static inline void store(float *p, reg v) { _mm512_store_ps(p, v); }
    static inline void store_unaligned(float *p, reg v) { _mm512_storeu_ps(p, v); }
    static inline void stream(float *p, reg v) { _mm512_stream_ps(p, v); }
    // streamed stores become visible to other threads in order
    static inline void fence() { _mm_sfence(); }
    static inline reg add(reg a, reg b) { return _mm512_add_ps(a, b); }
    static inline reg sub(reg a, reg b) { return _mm512_sub_ps(a, b); }
    static inline reg mul(reg a, reg b) { return _mm512_mul_ps(a, b); }
    static inline reg fma(reg a, reg b, reg c) { return _mm512_fmadd_ps(a, b, c); }
    static inline reg fnma(reg a, reg b, reg c) { return _mm512_fnmadd_ps(a, b, c); }
    static inline reg abs(reg a) { return _mm512_abs_ps(a); }
    static inline reg max(reg a, reg b) { return _mm512_max_ps(a, b); }
    static inline reg sqrt(reg a) { return _mm512_sqrt_ps(a); }
    static inline reg exp2(reg t) {
        t = _mm512_max_ps(t, _mm512_set1_ps(-126.f));
        const reg n = _mm512_roundscale_ps(t, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
        const reg f = _mm512_sub_ps(t, n);
        reg p = _mm512_set1_ps(kExp2[4]);
        p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(kExp2[3]));
        p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(kExp2[2]));
        p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(kExp2[1]));
        p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(kExp2[0]));
        p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(1.f));
        return _mm512_scalef_ps(p, n);
    }
    static inline void transpose(const float *from, float *to, int stride) {
        // each load puts four rows' quarters into one register, so that two rounds of shuffles within quarters remain
        for (int quarter = 0; quarter < 4; ++quarter) {
            reg r[4];
            for (int k = 0; k < 4; ++k) {
                const float *p = from + k * stride + 4 * quarter;
                reg v = _mm512_castps128_ps512(_mm_loadu_ps(p));
                v = _mm512_mask_broadcast_f32x4(v, 0x00f0, _mm_loadu_ps(p + 4 * stride));
                v = _mm512_mask_broadcast_f32x4(v, 0x0f00, _mm_loadu_ps(p + 8 * stride));
                r[k] = _mm512_mask_broadcast_f32x4(v, 0xf000, _mm_loadu_ps(p + 12 * stride));
            }
            const reg a = _mm512_unpacklo_ps(r[0], r[1]), b = _mm512_unpackhi_ps(r[0], r[1]);
            const reg c = _mm512_unpacklo_ps(r[2], r[3]), d = _mm512_unpackhi_ps(r[2], r[3]);
            float *q = to + 4 * quarter * stride;
            _mm512_storeu_ps(q, _mm512_shuffle_ps(a, c, 0x44));
            _mm512_storeu_ps(q + stride, _mm512_shuffle_ps(a, c, 0xee));
            _mm512_storeu_ps(q + 2 * stride, _mm512_shuffle_ps(b, d, 0x44));
            _mm512_storeu_ps(q + 3 * stride, _mm512_shuffle_ps(b, d, 0xee));
        }
    }
};

}  // namespace

constexpr kinesics::Kernels kinesics::kAvx512 = Pairs<Avx512>::kernels("avx512");
