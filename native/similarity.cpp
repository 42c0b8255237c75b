// Pairs of poses: packing, the choice of code path, threads, and the bindings. The arithmetic is in pairs_kernel.hpp.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pairs.hpp"
#include "threads.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace kinesics;

namespace {

using Doubles3 = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Doubles2 = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Doubles1 = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Index = nb::ndarray<const std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Floats2 = nb::ndarray<float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

struct AlignedDelete {
    void operator()(float *p) const { ::operator delete[](p, std::align_val_t(64)); }
};

// Packing fewer blocks takes a millisecond; waking threads on a busy machine can take longer.
constexpr std::int64_t kThreadedBlocks = 1024;

// Poses in the layout of pairs.hpp, float32, weights folded in.
class Poses {
   public:
    Poses(Doubles3 quaternions, Doubles2 gravity, Doubles1 weights, std::int64_t lead) {
        frames_ = std::int64_t(quaternions.shape(0));
        lead_ = lead;
        if (quaternions.shape(1) != kLinks || quaternions.shape(2) != 4 || gravity.shape(0) != quaternions.shape(0) ||
            gravity.shape(1) != 3 || weights.shape(0) != kLinks || lead < 0 || lead >= kLanes)
            throw std::invalid_argument("kinesics._native.Poses: shapes do not fit");
        const std::int64_t lanes = (frames_ + lead + kTile - 1) / kTile * kTile;
        const std::int64_t blocks = lanes / kLanes;
        blocks_.reset(new (std::align_val_t(64)) float[std::size_t(blocks) * kBlockFloats]);

        double total = 0;
        for (int i = 0; i < kLinks; ++i) total += weights(i);
        double factor[kLinks];
        for (int i = 1; i < kLinks; ++i) factor[i] = std::sqrt(weights(i) / total);
        const double root = weights(0) / total;
        root_constant_ = float(root * root / 2);
        const double gravity_factor = root / std::sqrt(2.0);

        // the row of each link's w: axial links first, then left and right limbs by pairs
        int first_row[kLinks];
        for (int k = 0; k < kAxial; ++k) first_row[1 + k] = 4 * k;
        for (int k = 0; k < kLimbPairs; ++k) {
            first_row[1 + kAxial + k] = kLimbRow + 8 * k;
            first_row[1 + kAxial + kLimbPairs + k] = kLimbRow + 8 * k + 4;
        }
        const double *q = quaternions.data();
        const double *g = gravity.data();
        float *const out = blocks_.get();
        const std::int64_t frames = frames_;
        parallel_for(blocks, blocks > kThreadedBlocks ? 0 : 1, [&](std::int64_t b) {
            float *block = out + std::size_t(b) * kBlockFloats;
            for (int lane = 0; lane < kLanes; ++lane) {
                const std::int64_t frame = b * kLanes + lane - lead;
                if (frame < 0 || frame >= frames) {
                    for (int row = 0; row < kRows; ++row) block[row * kLanes + lane] = 0.f;
                    continue;
                }
                for (int link = 1; link < kLinks; ++link)
                    for (int c = 0; c < 4; ++c)
                        block[(first_row[link] + c) * kLanes + lane] =
                            float(q[(frame * kLinks + link) * 4 + c] * factor[link]);
                for (int c = 0; c < 3; ++c)
                    block[(kGravityRow + c) * kLanes + lane] = float(g[frame * 3 + c] * gravity_factor);
            }
        });
    }

    // Some frames of other poses, in the order given.
    Poses(const Poses &of, Index frames) : frames_(std::int64_t(frames.shape(0))), root_constant_(of.root_constant_) {
        const std::int64_t *index = frames.data();
        for (std::int64_t k = 0; k < frames_; ++k)
            if (index[k] < 0 || index[k] >= of.frames_) throw std::invalid_argument("kinesics._native.Poses: no such frame");
        const std::int64_t lanes = (frames_ + kTile - 1) / kTile * kTile;
        blocks_.reset(new (std::align_val_t(64)) float[std::size_t(lanes / kLanes) * kBlockFloats]);
        for (std::int64_t b = 0; b < lanes / kLanes; ++b) {
            float *block = blocks_.get() + std::size_t(b) * kBlockFloats;
            for (int lane = 0; lane < kLanes; ++lane) {
                const std::int64_t k = b * kLanes + lane;
                if (k >= frames_) {
                    for (int row = 0; row < kRows; ++row) block[row * kLanes + lane] = 0.f;
                    continue;
                }
                const std::int64_t frame = index[k] + of.lead_;
                const float *from = of.blocks_.get() + std::size_t(frame / kLanes) * kBlockFloats + frame % kLanes;
                for (int row = 0; row < kRows; ++row) block[row * kLanes + lane] = from[row * kLanes];
            }
        }
    }

    std::int64_t frames() const { return frames_; }
    std::int64_t lead() const { return lead_; }
    Packed packed() const { return {blocks_.get(), frames_, lead_, root_constant_}; }

   private:
    std::unique_ptr<float[], AlignedDelete> blocks_;
    std::int64_t frames_ = 0;
    std::int64_t lead_ = 0;
    float root_constant_ = 0;
};

// Best first.
std::vector<const Kernels *> available() {
    std::vector<const Kernels *> out;
#ifdef KINESICS_X86_PATHS
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) out.push_back(&kAvx512);
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) out.push_back(&kAvx2);
#endif
    out.push_back(&kPortable);
    return out;
}

const Kernels &choose(const std::string &path) {
    static const std::vector<const Kernels *> all = available();
    if (path.empty()) return *all.front();
    for (const Kernels *k : all)
        if (path == k->name) return *k;
    throw std::invalid_argument("kinesics._native: this processor has no code path '" + path + "'");
}

std::vector<std::string> paths() {
    std::vector<std::string> out;
    for (const Kernels *k : available()) out.emplace_back(k->name);
    return out;
}

// Above this the caches would hold nothing of the result anyway.
constexpr std::int64_t kStreamBytes = 8 << 20;

std::int64_t tile_rows(const Packed &p) { return (p.frames + p.lead + kTile - 1) / kTile; }

std::int64_t tile_count(const Poses &poses) {
    const std::int64_t rows = tile_rows(poses.packed());
    return rows * (rows + 1) / 2;
}

float *data(const std::optional<Floats2> &array) { return array ? array->data() : nullptr; }

// Makes the operating system give memory to rows [first, last) of a fresh matrix. Adding nothing, atomically, is safe beside
// stores of other threads to the same page.
void touch(float *out, std::int64_t frames, std::int64_t first, std::int64_t last) {
    constexpr std::uintptr_t kPage = 4096;
    const auto begin = reinterpret_cast<std::uintptr_t>(out + first * frames);
    const auto end = reinterpret_cast<std::uintptr_t>(out + last * frames);
    for (std::uintptr_t page = (begin + kPage - 1) & ~(kPage - 1); page < end; page += kPage)
        reinterpret_cast<std::atomic<unsigned char> *>(page)->fetch_or(0, std::memory_order_relaxed);
}

// Tiles are numbered down the columns of the upper triangle: (0, 0), (0, 1), (1, 1), (0, 2) ... so that column J first
// writes to row band J. Where the matrices are fresh, giving them memory takes as long as filling them: it is a task of its
// own for each band, two bands ahead, so that one thread waits for memory while another computes, and no two threads ask for
// the same page at once.
void similarity_tiles(const Poses &poses, Floats2 z, std::optional<Floats2> z_mirror, double beta, std::int64_t first,
                      std::int64_t last, bool fresh, const std::string &path, int threads) {
    const Packed packed = poses.packed();
    const auto n = std::size_t(packed.frames);
    if (z.shape(0) != n || z.shape(1) != n || (z_mirror && (z_mirror->shape(0) != n || z_mirror->shape(1) != n)) ||
        first < 0 || last > tile_count(poses))
        throw std::invalid_argument("kinesics._native.similarity_tiles: shapes do not fit");
    const Kernels &kernels = choose(path);
    Job job{packed, packed, z.data(), data(z_mirror), packed.frames, true, float(-beta * 1.4426950408889634), false};
    job.stream = packed.frames * packed.frames * std::int64_t(sizeof(float)) > kStreamBytes;

    constexpr std::int64_t kAhead = 2;
    constexpr std::int64_t kTouch = -1;
    std::vector<std::pair<std::int64_t, std::int64_t>> tasks;
    tasks.reserve(std::size_t(std::max<std::int64_t>(0, last - first)));
    const std::int64_t bands = tile_rows(packed);
    std::int64_t k = 0;
    for (std::int64_t J = 0; J < bands; k += J + 1, ++J) {
        if (fresh && job.stream && k >= first && k < last)
            for (std::int64_t band = J == 0 ? 0 : J + kAhead; band <= J + kAhead && band < bands; ++band)
                tasks.emplace_back(kTouch, band);
        for (std::int64_t I = std::max<std::int64_t>(0, first - k); I <= J && k + I < last; ++I) tasks.emplace_back(I, J);
    }
    nb::gil_scoped_release release;
    parallel_for(std::int64_t(tasks.size()), threads, [&](std::int64_t t) {
        const auto [I, J] = tasks[std::size_t(t)];
        if (I != kTouch) {
            kernels.symmetric_tile(job, I, J);
            return;
        }
        const std::int64_t from = std::max<std::int64_t>(0, J * kTile - packed.lead);
        const std::int64_t to = std::min(packed.frames, (J + 1) * kTile - packed.lead);
        for (float *out : {job.out, job.out_mirror})
            if (out != nullptr) touch(out, packed.frames, from, to);
    });
}

void distances(const Poses &a, const Poses &b, Floats2 d, std::optional<Floats2> d_mirror, std::int64_t row_start,
               std::int64_t column_start, const std::string &path, int threads) {
    const auto rows = std::int64_t(d.shape(0)), columns = std::int64_t(d.shape(1));
    if (a.lead() != 0 || b.lead() != 0 || row_start < 0 || column_start < 0 || row_start % kLanes || column_start % kLanes ||
        row_start + rows > a.frames() || column_start + columns > b.frames() ||
        (d_mirror && (d_mirror->shape(0) != d.shape(0) || d_mirror->shape(1) != d.shape(1))))
        throw std::invalid_argument("kinesics._native.distances: shapes do not fit");
    if (rows == 0 || columns == 0) return;
    const Kernels &kernels = choose(path);
    auto part = [](Packed p, std::int64_t start, std::int64_t count) {
        p.blocks += std::size_t(start / kLanes) * kBlockFloats;
        p.frames = count;
        return p;
    };
    const Job job{part(a.packed(), row_start, rows),
                  part(b.packed(), column_start, columns),
                  d.data(),
                  data(d_mirror),
                  columns,
                  false,
                  0.f,
                  rows * columns * std::int64_t(sizeof(float)) > kStreamBytes};
    const std::int64_t across = tile_rows(job.b);
    nb::gil_scoped_release release;
    parallel_for(tile_rows(job.a) * across, threads, [&](std::int64_t t) { kernels.tile(job, t / across, t % across); });
}

// The larger the part, the less of D is computed twice; the smaller, the better it fits into the cache of one core.
std::int64_t window_side(std::int64_t length) { return length <= 32 ? kTile : length <= 128 ? 2 * kTile : 4 * kTile; }

void diagonal_sums(const Poses &a, const Poses &b, std::int64_t length, Floats2 d, std::optional<Floats2> d_mirror,
                   const std::string &path, int threads) {
    const std::int64_t rows = a.frames() - length + 1, columns = b.frames() - length + 1;
    if (a.lead() != 0 || b.lead() != 0 || length < 1 || rows < 1 || columns < 1 || std::int64_t(d.shape(0)) != rows ||
        std::int64_t(d.shape(1)) != columns ||
        (d_mirror && (d_mirror->shape(0) != d.shape(0) || d_mirror->shape(1) != d.shape(1))))
        throw std::invalid_argument("kinesics._native.diagonal_sums: shapes do not fit");
    const Kernels &kernels = choose(path);
    const bool stream = rows * columns * std::int64_t(sizeof(float)) > kStreamBytes;
    const Job pairs{a.packed(), b.packed(), d.data(), data(d_mirror), columns, false, 0.f, stream};
    const std::int64_t side = window_side(length), reach = (side + length - 1 + kLanes - 1) / kLanes * kLanes;
    // an odd number of cache lines from row to row, as in kScratchStride
    const std::int64_t stride = reach + (reach / kLanes % 2 == 0 ? kLanes : 0);
    const WindowJob job{pairs, length, side, &a == &b, reach, stride};
    const std::int64_t down = (rows + job.side - 1) / job.side, across = (columns + job.side - 1) / job.side;
    nb::gil_scoped_release release;
    parallel_for(down, threads, [&](std::int64_t I) {
        const std::unique_ptr<float[], AlignedDelete> scratch(new (std::align_val_t(64)) float[3 * std::size_t(reach * stride)]);
        for (std::int64_t J = job.symmetric ? I : 0; J < across; ++J) kernels.windows(job, I, J, scratch.get());
    });
}

}  // namespace

void bind_similarity(nb::module_ &m) {
    nb::class_<Poses>(m, "Poses")
        .def(nb::init<Doubles3, Doubles2, Doubles1, std::int64_t>(), "quaternions"_a.noconvert(), "gravity"_a.noconvert(),
             "weights"_a.noconvert(), "lead"_a = 0)
        .def("taken", [](const Poses &of, Index frames) { return std::make_unique<Poses>(of, frames); },
             "frames"_a.noconvert())
        .def_prop_ro("frames", &Poses::frames)
        .def_prop_ro("tile_count", &tile_count);
    m.def("similarity_tiles", &similarity_tiles, "poses"_a, "z"_a.noconvert(), "z_mirror"_a.noconvert().none(), "beta"_a,
          "first"_a, "last"_a, "fresh"_a = false, "path"_a = "", "threads"_a = 0);
    m.def("distances", &distances, "a"_a, "b"_a, "d"_a.noconvert(), "d_mirror"_a.noconvert().none(), "row_start"_a = 0,
          "column_start"_a = 0, "path"_a = "", "threads"_a = 0);
    m.def("diagonal_sums", &diagonal_sums, "a"_a, "b"_a, "length"_a, "d"_a.noconvert(), "d_mirror"_a.noconvert().none(),
          "path"_a = "", "threads"_a = 0);
    m.def("paths", &paths);
}
