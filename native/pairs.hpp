// What every code path of the pair kernels shares: the layout of packed poses and the jobs they are given.
//
// D = 1 - sum_i w_i |q_i . g_i| over 14 links and w_root sqrt((1 + g.h)/2) for the root, weights summing to 1; D* is the same
// against the mirrored second pose. The weights are folded into the packed numbers, so the inner loop never sees them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kinesics {

constexpr int kLinks = 15;
constexpr int kAxial = 6;      // links 1..6, each its own mirror partner
constexpr int kLimbPairs = 4;  // links 7..10 with 11..14
constexpr int kLanes = 16;     // frames in a block: the widest vector
constexpr int kTile = 128;     // frames on a side of a tile
constexpr int kScratchStride = kTile + kLanes;  // an odd number of cache lines: columns do not fall on one set

// Rows of a block. Axial: w x y z each. Limb pairs: left w x y z, right w x y z. Then gravity x y z.
constexpr int kLimbRow = 4 * kAxial;
constexpr int kGravityRow = kLimbRow + 8 * kLimbPairs;
constexpr int kRows = kGravityRow + 3;
constexpr std::size_t kBlockFloats = std::size_t(kRows) * kLanes;

// 2^f - 1 = f (c0 + c1 f + ...) on [-1/2, 1/2]: a minimax fit, relative error of 2^f below 1e-7, exact at 0.
constexpr float kExp2[5] = {0.6931470036506653f, 0.24022242426872253f, 0.05550733581185341f, 0.009671512991189957f,
                            0.001326472731307149f};

// Poses as blocks of kRows x kLanes floats. `lead` empty frames come first, so that tiles can be laid on the cache lines
// of the array they are written to; empty frames also fill the last tile.
struct Packed {
    const float *blocks;
    std::int64_t frames;
    std::int64_t lead;
    float root_constant;  // w_root^2 / 2
};

// What to compute and where to put it. An output that is null is not wanted; D* alone is not asked for: mirror b instead.
struct Job {
    Packed a;  // rows
    Packed b;  // columns
    float *out;
    float *out_mirror;
    std::int64_t row_stride;  // floats
    bool similarity;          // write exp(-beta D), else D
    float scale;              // -beta log2(e)
    bool stream;              // non-temporal stores
};

// Sums of D along diagonals: out(i, j) = sum over l < length of D(i + l, j + l), in parts of `side` x `side`.
struct WindowJob {
    Job pairs;  // lead 0; `out` has as many rows and columns as there are windows, row_stride columns
    std::int64_t length;
    std::int64_t side;  // a multiple of kTile
    bool symmetric;     // a and b are the same: parts I <= J write both halves

    // Rows and columns of D under one part, in whole blocks, and floats from row to row; three such squares are the
    // scratch of a thread. (Fields, not functions: an inline function would be compiled for several processors and the
    // linker might keep the wrong one.)
    std::int64_t reach;
    std::int64_t stride;
};

struct Kernels {
    const char *name;
    // Tile (I, J), I <= J, of a symmetric job (a and b the same): writes both halves.
    void (*symmetric_tile)(const Job &, std::int64_t I, std::int64_t J);
    // Tile (I, J) of a rectangular job.
    void (*tile)(const Job &, std::int64_t I, std::int64_t J);
    // Part (I, J) of the sums along diagonals.
    void (*windows)(const WindowJob &, std::int64_t I, std::int64_t J, float *scratch);
};

extern const Kernels kPortable;
#ifdef KINESICS_X86_PATHS
extern const Kernels kAvx2;
extern const Kernels kAvx512;
#endif

}  // namespace kinesics
