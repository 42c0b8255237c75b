// The pair kernels, written once over a vector type V. Each code path includes this file in a source compiled with its own
// flags; all is in an unnamed namespace and nothing from the standard library is called, so that no function built for a
// newer processor can be picked by the linker for an older one.
//
// V offers: width, rows (rows of pairs held in registers at once), reg, load, broadcast, store, stream, fence, add, sub, mul,
// fma (a b + c), fnma (c - a b), abs, max, sqrt, exp2, transpose.
#pragma once

#include "pairs.hpp"

namespace {

using namespace kinesics;

template <class V>
struct Pairs {
    using reg = typename V::reg;
    static constexpr int R = V::rows;
    static constexpr int W = V::width;

    static inline reg dot(const float *a, const reg *b) {
        reg sum = V::mul(V::broadcast(a[0]), b[0]);
        sum = V::fma(V::broadcast(a[kLanes]), b[1], sum);
        sum = V::fma(V::broadcast(a[2 * kLanes]), b[2], sum);
        return V::fma(V::broadcast(a[3 * kLanes]), b[3], sum);
    }
    static inline reg dot_mirror(const float *a, const reg *b) {
        reg sum = V::mul(V::broadcast(a[0]), b[0]);
        sum = V::fma(V::broadcast(a[kLanes]), b[1], sum);
        sum = V::fnma(V::broadcast(a[2 * kLanes]), b[2], sum);
        return V::fnma(V::broadcast(a[3 * kLanes]), b[3], sum);
    }

    // R rows against W columns: D, and with Mirror D* too.
    template <bool Mirror>
    static inline void distances(const float *row, const float *column, float root_constant, reg *d, reg *dm) {
        reg sum[R], sum_m[R];
        for (int r = 0; r < R; ++r) sum[r] = sum_m[r] = V::broadcast(0.f);

        for (int link = 0; link < kAxial; ++link) {
            const float *a = row + 4 * link * kLanes;
            const float *b = column + 4 * link * kLanes;
            const reg bw = V::load(b), bx = V::load(b + kLanes), by = V::load(b + 2 * kLanes), bz = V::load(b + 3 * kLanes);
#pragma GCC unroll 16
            for (int r = 0; r < R; ++r) {
                // q.(w g) differs from q.g only in the sign of y and z: both share the halves
                const reg wx = V::fma(V::broadcast(a[kLanes + r]), bx, V::mul(V::broadcast(a[r]), bw));
                if constexpr (Mirror) {
                    const reg yz =
                        V::fma(V::broadcast(a[3 * kLanes + r]), bz, V::mul(V::broadcast(a[2 * kLanes + r]), by));
                    sum[r] = V::add(sum[r], V::abs(V::add(wx, yz)));
                    sum_m[r] = V::add(sum_m[r], V::abs(V::sub(wx, yz)));
                } else {
                    const reg wxy = V::fma(V::broadcast(a[2 * kLanes + r]), by, wx);
                    sum[r] = V::add(sum[r], V::abs(V::fma(V::broadcast(a[3 * kLanes + r]), bz, wxy)));
                }
            }
        }
        for (int pair = 0; pair < kLimbPairs; ++pair) {
            const float *b = column + (kLimbRow + 8 * pair) * kLanes;
            const float *a = row + (kLimbRow + 8 * pair) * kLanes;
            reg left[4], right[4];
            for (int c = 0; c < 4; ++c) {
                left[c] = V::load(b + c * kLanes);
                right[c] = V::load(b + (4 + c) * kLanes);
            }
#pragma GCC unroll 16
            for (int r = 0; r < R; ++r) {
                const float *al = a + r, *ar = a + 4 * kLanes + r;
                // the two limbs are added first: then D* is the same to the last bit when the poses change places
                sum[r] = V::add(sum[r], V::add(V::abs(dot(al, left)), V::abs(dot(ar, right))));
                if constexpr (Mirror)
                    sum_m[r] = V::add(sum_m[r], V::add(V::abs(dot_mirror(al, right)), V::abs(dot_mirror(ar, left))));
            }
        }
        const float *g = row + kGravityRow * kLanes;
        const float *h = column + kGravityRow * kLanes;
        const reg hx = V::load(h), hy = V::load(h + kLanes), hz = V::load(h + 2 * kLanes);
        const reg zero = V::broadcast(0.f), one = V::broadcast(1.f), constant = V::broadcast(root_constant);
#pragma GCC unroll 16
        for (int r = 0; r < R; ++r) {
            const reg x = V::mul(V::broadcast(g[r]), hx);
            reg yz = V::fma(V::broadcast(g[kLanes + r]), hy, constant);
            yz = V::fma(V::broadcast(g[2 * kLanes + r]), hz, yz);
            // opposite directions: rounding may leave less than nothing under the root
            d[r] = V::max(zero, V::sub(one, V::add(sum[r], V::sqrt(V::max(zero, V::add(yz, x))))));
            if constexpr (Mirror)
                dm[r] = V::max(zero, V::sub(one, V::add(sum_m[r], V::sqrt(V::max(zero, V::sub(yz, x))))));
        }
    }

    // Rows [row0, row0 + count_r) against columns [column0, column0 + count_c), in lanes counted with the lead, into scratch.
    template <bool Mirror, bool Exp>
    static void fill(const Job &job, std::int64_t row0, int count_r, std::int64_t column0, int count_c, int stride,
                     float *out, float *out_m) {
        const reg scale = V::broadcast(job.scale);
        for (int c = 0; c < count_c; c += W) {
            const std::int64_t lane = column0 + c;
            const float *column = job.b.blocks + (lane / kLanes) * kBlockFloats + lane % kLanes;
            for (int r0 = 0; r0 < count_r; r0 += R) {
                const std::int64_t frame = row0 + r0;
                const float *row = job.a.blocks + (frame / kLanes) * kBlockFloats + frame % kLanes;
                reg d[R], dm[R];
                distances<Mirror>(row, column, job.a.root_constant, d, dm);
#pragma GCC unroll 16
                for (int r = 0; r < R; ++r) {
                    const std::size_t at = std::size_t(r0 + r) * stride + c;
                    V::store(out + at, Exp ? V::exp2(V::mul(d[r], scale)) : d[r]);
                    if constexpr (Mirror) V::store(out_m + at, Exp ? V::exp2(V::mul(dm[r], scale)) : dm[r]);
                }
            }
        }
    }

    static void fill_any(const Job &job, std::int64_t row0, int count_r, std::int64_t column0, int count_c, int stride,
                         float *out, float *out_m) {
        if (out_m != nullptr) {
            if (job.similarity)
                fill<true, true>(job, row0, count_r, column0, count_c, stride, out, out_m);
            else
                fill<true, false>(job, row0, count_r, column0, count_c, stride, out, out_m);
        } else if (job.similarity) {
            fill<false, true>(job, row0, count_r, column0, count_c, stride, out, out_m);
        } else {
            fill<false, false>(job, row0, count_r, column0, count_c, stride, out, out_m);
        }
    }

    static inline void copy_row(float *to, const float *from, std::int64_t count, bool stream) {
        std::int64_t i = 0;
        if (stream) {
            // whole cache lines go past the caches: nothing is read back, and the poses stay in them
            for (; i < count && (reinterpret_cast<std::uintptr_t>(to + i) & 63) != 0; ++i) to[i] = from[i];
            for (; i + kLanes <= count; i += kLanes)
                for (int k = 0; k < kLanes; k += W) V::stream(to + i + k, V::load_unaligned(from + i + k));
        }
        for (; i + W <= count; i += W) V::store_unaligned(to + i, V::load_unaligned(from + i));
        for (; i < count; ++i) to[i] = from[i];
    }

    static void transpose(const float *from, float *to, int side, int stride) {
        for (int r = 0; r < side; r += W)
            for (int c = 0; c < side; c += W) V::transpose(from + r * stride + c, to + c * stride + r, stride);
    }

    // The span of tile I: first lane with a frame in it, and how many frames.
    struct Span {
        std::int64_t frame;
        int skip;
        int count;
    };
    static Span span(const Packed &p, std::int64_t I) {
        const std::int64_t from = I * kTile < p.lead ? p.lead : I * kTile;
        const std::int64_t last = p.lead + p.frames;
        const std::int64_t to = (I + 1) * kTile < last ? (I + 1) * kTile : last;
        return {from - p.lead, int(from - I * kTile), int(to - from)};
    }

    static int in_blocks(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

    static void symmetric_tile(const Job &job, std::int64_t I, std::int64_t J) {
        alignas(64) float d[kTile * kScratchStride];
        alignas(64) float dm[kTile * kScratchStride];
        alignas(64) float turned[kTile * kScratchStride];
        const Span rows = span(job.a, I), columns = span(job.a, J);
        fill_any(job, I * kTile, in_blocks(rows.skip + rows.count), J * kTile, in_blocks(columns.skip + columns.count),
                 kScratchStride, d, job.out_mirror ? dm : nullptr);
        float *scratch[2] = {d, dm};
        float *out[2] = {job.out, job.out_mirror};
        for (int m = 0; m < 2; ++m) {
            if (out[m] == nullptr) continue;
            if (I == J && m == 0)  // a pose is at distance 0 from itself, whatever rounding says
                for (int r = 0; r < kTile; ++r) d[r * kScratchStride + r] = job.similarity ? 1.f : 0.f;
            for (int r = 0; r < rows.count; ++r)
                copy_row(out[m] + (rows.frame + r) * job.row_stride + columns.frame,
                         scratch[m] + (rows.skip + r) * kScratchStride + columns.skip, columns.count, job.stream);
            if (I == J) continue;
            transpose(scratch[m], turned, kTile, kScratchStride);
            for (int c = 0; c < columns.count; ++c)
                copy_row(out[m] + (columns.frame + c) * job.row_stride + rows.frame,
                         turned + (columns.skip + c) * kScratchStride + rows.skip, rows.count, job.stream);
        }
        V::fence();
    }

    static void tile(const Job &job, std::int64_t I, std::int64_t J) {
        alignas(64) float d[kTile * kScratchStride];
        alignas(64) float dm[kTile * kScratchStride];
        const Span rows = span(job.a, I), columns = span(job.b, J);
        fill_any(job, I * kTile, in_blocks(rows.skip + rows.count), J * kTile, in_blocks(columns.skip + columns.count),
                 kScratchStride, d, job.out_mirror ? dm : nullptr);
        const float *scratch[2] = {d, dm};
        float *out[2] = {job.out, job.out_mirror};
        for (int m = 0; m < 2; ++m) {
            if (out[m] == nullptr) continue;
            for (int r = 0; r < rows.count; ++r)
                copy_row(out[m] + (rows.frame + r) * job.row_stride + columns.frame,
                         scratch[m] + (rows.skip + r) * kScratchStride + columns.skip, columns.count, job.stream);
        }
        V::fence();
    }

    // to(i, j) = a(i, j) + b(i, j); `to` may be `a`, and b may lie ahead in it.
    static inline void add_rows(float *to, const float *a, const float *b, std::int64_t rows, std::int64_t columns,
                                std::int64_t stride) {
        for (std::int64_t r = 0; r < rows; ++r, to += stride, a += stride, b += stride) {
            std::int64_t c = 0;
            for (; c + W <= columns; c += W)
                V::store_unaligned(to + c, V::add(V::load_unaligned(a + c), V::load_unaligned(b + c)));
            for (; c < columns; ++c) to[c] = a[c] + b[c];
        }
    }

    // Turns D in `d` (rows x columns) into its sums over `length` along diagonals, by doubling: a window of 2k is two of k.
    // Returns where they are: `d` itself, or `total` where the length is no power of two.
    static const float *sum_diagonals(float *d, float *total, std::int64_t rows, std::int64_t columns, std::int64_t stride,
                                      std::int64_t length) {
        std::int64_t done = 0;  // frames already in `total`
        for (std::int64_t power = 1;; power *= 2) {
            // here d(i, j) holds the sum over `power` frames, for `power` - 1 fewer rows and columns than D
            if (length & power) {
                const float *part = d + done * (stride + 1);
                const std::int64_t r = rows - done - power + 1, c = columns - done - power + 1;
                if (done == 0 && power == length) return d;
                if (done == 0) {
                    for (std::int64_t i = 0; i < r; ++i) copy_row(total + i * stride, part + i * stride, c, false);
                } else {
                    add_rows(total, total, part, r, c, stride);
                }
                done += power;
                if (done == length) return total;
            }
            add_rows(d, d, d + power * (stride + 1), rows - 2 * power + 1, columns - 2 * power + 1, stride);
        }
    }

    static void windows(const WindowJob &job, std::int64_t I, std::int64_t J, float *scratch) {
        const std::int64_t stride = job.stride, reach = job.reach, side = job.side;
        const std::int64_t row0 = I * side, column0 = J * side;
        auto within = [](std::int64_t a, std::int64_t b) { return a < b ? a : b; };
        // pairs under this part, and windows in it
        const std::int64_t rows = within(side + job.length - 1, job.pairs.a.frames - row0);
        const std::int64_t columns = within(side + job.length - 1, job.pairs.b.frames - column0);
        const std::int64_t out_rows = rows - job.length + 1, out_columns = columns - job.length + 1;
        float *d = scratch, *dm = d + reach * stride, *spare = dm + reach * stride;
        fill_any(job.pairs, row0, in_blocks(int(rows)), column0, in_blocks(int(columns)), int(stride), d,
                 job.pairs.out_mirror ? dm : nullptr);
        float *squares[2] = {d, dm};
        float *out[2] = {job.pairs.out, job.pairs.out_mirror};
        for (int m = 0; m < 2; ++m) {
            if (out[m] == nullptr) continue;
            if (job.symmetric && I == J && m == 0)
                for (std::int64_t r = 0; r < rows; ++r) d[r * stride + r] = 0.f;
            const float *sums = sum_diagonals(squares[m], spare, rows, columns, stride, job.length);
            for (std::int64_t r = 0; r < out_rows; ++r)
                copy_row(out[m] + (row0 + r) * job.pairs.row_stride + column0, sums + r * stride, out_columns,
                         job.pairs.stream);
            if (!job.symmetric || I == J) continue;
            float *turned = sums == spare ? squares[m] : spare;
            transpose(sums, turned, int(side), int(stride));
            for (std::int64_t c = 0; c < out_columns; ++c)
                copy_row(out[m] + (column0 + c) * job.pairs.row_stride + row0, turned + c * stride, out_rows,
                         job.pairs.stream);
        }
        V::fence();
    }

    static constexpr Kernels kernels(const char *name) { return {name, symmetric_tile, tile, windows}; }
};

}  // namespace
