// The pair kernels for processors with AVX2 and FMA.
#include <immintrin.h>

#include "pairs_kernel.hpp"

namespace {

struct Avx2 {
    using reg = __m256;
    static constexpr int width = 8;
    static constexpr int rows = 4;
    static inline reg load(const float *p) { return _mm256_load_ps(p); }
    static inline reg load_unaligned(const float *p) { return _mm256_loadu_ps(p); }
    static inline reg broadcast(float v) { return _mm256_set1_ps(v); }
    static inline void store(float *p, reg v) { _mm256_store_ps(p, v); }
    static inline void store_unaligned(float *p, reg v) { _mm256_storeu_ps(p, v); }
    static inline void stream(float *p, reg v) { _mm256_stream_ps(p, v); }
    // streamed stores become visible to other threads in order
    static inline void fence() { _mm_sfence(); }
    static inline reg add(reg a, reg b) { return _mm256_add_ps(a, b); }
    static inline reg sub(reg a, reg b) { return _mm256_sub_ps(a, b); }
    static inline reg mul(reg a, reg b) { return _mm256_mul_ps(a, b); }
    static inline reg fma(reg a, reg b, reg c) { return _mm256_fmadd_ps(a, b, c); }
    static inline reg fnma(reg a, reg b, reg c) { return _mm256_fnmadd_ps(a, b, c); }
    static inline reg abs(reg a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.f), a); }
    static inline reg max(reg a, reg b) { return _mm256_max_ps(a, b); }
    static inline reg sqrt(reg a) { return _mm256_sqrt_ps(a); }
    static inline reg exp2(reg t) {
        t = _mm256_max_ps(t, _mm256_set1_ps(-126.f));
        const reg n = _mm256_round_ps(t, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
        const reg f = _mm256_sub_ps(t, n);
        reg p = _mm256_set1_ps(kExp2[4]);
        p = _mm256_fmadd_ps(p, f, _mm256_set1_ps(kExp2[3]));
        p = _mm256_fmadd_ps(p, f, _mm256_set1_ps(kExp2[2]));
        p = _mm256_fmadd_ps(p, f, _mm256_set1_ps(kExp2[1]));
        p = _mm256_fmadd_ps(p, f, _mm256_set1_ps(kExp2[0]));
        p = _mm256_fmadd_ps(p, f, _mm256_set1_ps(1.f));
        const __m256i exponent = _mm256_slli_epi32(_mm256_cvtps_epi32(n), 23);
        return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(p), exponent));
    }
    static inline void transpose(const float *from, float *to, int stride) {
        for (int half = 0; half < 2; ++half) {
            reg r[4];
            for (int k = 0; k < 4; ++k) {
                const float *p = from + k * stride + 4 * half;
                r[k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p)), _mm_loadu_ps(p + 4 * stride), 1);
            }
            const reg a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpackhi_ps(r[0], r[1]);
            const reg c = _mm256_unpacklo_ps(r[2], r[3]), d = _mm256_unpackhi_ps(r[2], r[3]);
            float *q = to + 4 * half * stride;
            _mm256_storeu_ps(q, _mm256_shuffle_ps(a, c, 0x44));
            _mm256_storeu_ps(q + stride, _mm256_shuffle_ps(a, c, 0xee));
            _mm256_storeu_ps(q + 2 * stride, _mm256_shuffle_ps(b, d, 0x44));
            _mm256_storeu_ps(q + 3 * stride, _mm256_shuffle_ps(b, d, 0xee));
        }
    }
};

}  // namespace

constexpr kinesics::Kernels kinesics::kAvx2 = Pairs<Avx2>::kernels("avx2");
