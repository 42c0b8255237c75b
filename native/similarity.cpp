#include <nanobind/nanobind.h>
namespace nb = nanobind;
void bind_similarity(nb::module_ &) {}
