// Where feet and body go so that bearing feet stay: assembly and solution of a block-banded system of least squares. What is
// summed is said in kinesics/synthesis/embodiment/footing.py, where the NumPy twin is.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using In2 = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

constexpr int kBlock = 9;             // unknowns of a frame: left foot, right foot, body
constexpr int kBody = 6;              // where those of the body begin
constexpr int kWindow = 3 * kBlock;   // a frame is coupled with itself and the next two
constexpr int kSide = kWindow;        // row of the right-hand side
constexpr int kStride = kWindow + 1;  // a column of the window, a whole number of vectors

// Second differences of what bends: share times what frame `late` has with frame `early`, added to the block that starts at `at`
// (rows: late, columns: early).
struct Bending {
    const double *knees, *hips;
    double foot, body;

    void add(double share, std::int64_t early, std::int64_t late, double *at) const {
        for (int k = 0; k < 2; ++k) {
            const double *a = knees + 6 * early + 3 * k, *b = knees + 6 * late + 3 * k;
            const double turning = share * hips[2 * early + k] * hips[2 * late + k];
            for (int i = 0; i < 3; ++i) {
                double *foot_column = at + (3 * k + i) * kStride, *body_column = at + (kBody + i) * kStride;
                for (int j = 0; j < 3; ++j) {
                    const double value = share * a[i] * b[j] + (i == j ? turning : 0.0);
                    foot_column[3 * k + j] += value;
                    foot_column[kBody + j] -= value;
                    body_column[3 * k + j] -= value;
                    body_column[kBody + j] += value;
                }
                foot_column[3 * k + i] += share * foot;
            }
        }
        for (int i = 0; i < 3; ++i) at[(kBody + i) * kStride + kBody + i] += share * body;
    }
};

// Eliminates the unknowns of the window's first frame; columns of L go to `factor`, with the right-hand side as far as it is
// solved. False where the matrix is not positive.
bool eliminate(double *window, double *factor) {
    for (int c = 0; c < kBlock; ++c) {
        const double *column = window + c * kStride;
        double *l = factor + c * kStride;
        if (!(column[c] > 0.0)) return false;
        const double inverse = 1.0 / column[c];
        for (int r = 0; r <= c; ++r) l[r] = 0.0;
        for (int r = c + 1; r < kStride; ++r) l[r] = inverse * column[r];
        for (int d = c + 1; d < kWindow; ++d) {
            double *other = window + d * kStride;
            const double by = l[d];
            // from the vector on that holds the diagonal: what lies above it is never read
            for (int r = d & ~3; r < kStride; r += 4)
                for (int n = 0; n < 4; ++n) other[r + n] -= by * column[r + n];
        }
    }
    return true;
}

// The next frame becomes the first of the window, and an empty one its last.
void move_on(double *window) {
    for (int c = 0; c < kWindow; ++c) {
        double *column = window + c * kStride;
        if (c >= kWindow - kBlock) {
            std::memset(column, 0, kStride * sizeof(double));
            continue;
        }
        const double *next = column + kBlock * kStride;
        std::memcpy(column, next + kBlock, (kWindow - kBlock) * sizeof(double));
        std::memset(column + kWindow - kBlock, 0, kBlock * sizeof(double));
        column[kSide] = next[kSide];
    }
}

bool seek_footing(In3 knees, In2 hips, double foot, double body, In3 slid, In2 grip, In2 height, In2 press, In3 way, In2 least,
                  double astray, In2 drift, Out2 out) {
    const auto frames = std::int64_t(out.shape(0));
    auto fits = [](const auto &array, std::int64_t rows, std::size_t columns) {
        return std::int64_t(array.shape(0)) == rows && array.shape(1) == columns;
    };
    if (!(frames > 2 && fits(out, frames, kBlock) && fits(knees, frames, 2) && knees.shape(2) == 3 && fits(hips, frames, 2) &&
          fits(slid, frames - 1, 2) && slid.shape(2) == 2 && fits(grip, frames - 1, 2) && fits(height, frames, 2) &&
          fits(press, frames, 2) && fits(way, frames, 2) && way.shape(2) == 3 && fits(least, frames, 2) && fits(drift, frames, 3)))
        throw std::invalid_argument("kinesics._native.seek_footing: shapes do not fit");
    const Bending bending{knees.data(), hips.data(), foot, body};
    const double *slips = slid.data(), *grips = grip.data(), *heights = height.data(), *presses = press.data();
    const double *ways = way.data(), *leasts = least.data(), *drifts = drift.data();
    double *found = out.data();
    nb::gil_scoped_release release;

    const std::unique_ptr<double[]> factor(new double[std::size_t(frames * kBlock * kStride)]);
    alignas(64) double window[kWindow * kStride] = {};
    for (std::int64_t t = 0; t < frames; ++t) {
        const bool before = t >= 1, after = t + 1 < frames;
        // second differences that this frame begins, is the middle of, and ends
        const double begins = t + 2 < frames ? 1.0 : 0.0, middle = before && after ? 1.0 : 0.0, ends = t >= 2 ? 1.0 : 0.0;
        bending.add(begins + 4.0 * middle + ends, t, t, window);
        if (after) bending.add(-2.0 * (begins + middle), t, t + 1, window + kBlock);
        if (begins > 0.0) bending.add(1.0, t, t + 2, window + 2 * kBlock);
        for (int k = 0; k < 2; ++k) {
            for (int n = 0; n < 2; ++n) {
                const int c = 3 * k + 2 * n;
                double *column = window + c * kStride;
                if (before) {
                    const std::int64_t at = 2 * (t - 1) + k;
                    const double weight = grips[at] * grips[at];
                    column[c] += weight;
                    column[kSide] -= weight * slips[2 * at + n];
                }
                if (after) {
                    const std::int64_t at = 2 * t + k;
                    const double weight = grips[at] * grips[at];
                    column[c] += weight;
                    column[kBlock + c] -= weight;
                    column[kSide] += weight * slips[2 * at + n];
                }
            }
            const std::int64_t at = 2 * t + k;
            const double weight = presses[at] * presses[at];
            window[(3 * k + 1) * kStride + 3 * k + 1] += weight;
            window[(3 * k + 1) * kStride + kSide] -= weight * heights[at];
            const double *bound = ways + 3 * at;
            for (int i = 0; i < 3; ++i) {
                double *foot_column = window + (3 * k + i) * kStride, *body_column = window + (kBody + i) * kStride;
                for (int j = 0; j < 3; ++j) {
                    const double firm = bound[i] * bound[j] + (i == j ? astray : 0.0);
                    foot_column[3 * k + j] += firm;
                    foot_column[kBody + j] -= firm;
                    body_column[kBody + j] += firm;
                }
                foot_column[kSide] += bound[i] * leasts[at];
                body_column[kSide] -= bound[i] * leasts[at];
            }
        }
        for (int i = 0; i < 3; ++i) window[(kBody + i) * kStride + kBody + i] += drifts[3 * t + i];
        if (!eliminate(window, factor.get() + t * kBlock * kStride)) return false;
        move_on(window);
    }

    // backwards: of the frame, of the next two
    alignas(64) double known[kStride] = {};
    for (std::int64_t t = frames - 1; t >= 0; --t) {
        std::memmove(known + kBlock, known, (kWindow - kBlock) * sizeof(double));
        std::memset(known, 0, kBlock * sizeof(double));
        for (int c = kBlock - 1; c >= 0; --c) {
            const double *l = factor.get() + (t * kBlock + c) * kStride;
            double sums[4] = {};
            for (int r = 0; r < kStride; r += 4)
                for (int n = 0; n < 4; ++n) sums[n] += l[r + n] * known[r + n];
            known[c] = l[kSide] - ((sums[0] + sums[2]) + (sums[1] + sums[3]));
        }
        std::memcpy(found + t * kBlock, known, kBlock * sizeof(double));
    }
    return true;
}

}  // namespace

void bind_footing(nb::module_ &m) {
    m.def("seek_footing", &seek_footing, "knees"_a.noconvert(), "hips"_a.noconvert(), "foot"_a, "body"_a, "slid"_a.noconvert(),
          "grip"_a.noconvert(), "height"_a.noconvert(), "press"_a.noconvert(), "way"_a.noconvert(), "least"_a.noconvert(),
          "astray"_a, "drift"_a.noconvert(), "out"_a.noconvert());
}
