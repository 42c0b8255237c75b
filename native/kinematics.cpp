#include <nanobind/nanobind.h>
namespace nb = nanobind;
void bind_kinematics(nb::module_ &) {}
