#include <pybind11/numpy.h>

#include <vector>

#include "bind.hpp"
#include "perimpm/error.hpp"
#include "perimpm/geometry/shape.hpp"

namespace perimpm::python {
namespace {

using Points = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::tuple surface_of(const Points& x, double spacing) {
    if (x.ndim() != 2 || x.shape(1) != 3) throw InputError("expected places of shape (n, 3)");
    std::vector<Vec3> points(static_cast<std::size_t>(x.shape(0)));
    for (std::size_t n = 0; n < points.size(); ++n) points[n] = Eigen::Map<const Vec3>(x.data() + 3 * n);
    TriangleMesh mesh;
    {
        const py::gil_scoped_release release;
        mesh = surface_around(points, spacing);
    }
    py::array_t<double> corners({static_cast<py::ssize_t>(mesh.points.size()), py::ssize_t{3}});
    for (std::size_t n = 0; n < mesh.points.size(); ++n)
        Eigen::Map<Vec3>(corners.mutable_data() + 3 * n) = mesh.points[n];
    py::array_t<std::uint32_t> triangles({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t{3}});
    for (std::size_t n = 0; n < mesh.triangles.size(); ++n)
        std::copy(mesh.triangles[n].begin(), mesh.triangles[n].end(), triangles.mutable_data() + 3 * n);
    return py::make_tuple(corners, triangles);
}

}  // namespace

void bind_geometry(py::module_& m) {
    m.def("surface_around", &surface_of, py::arg("x"), py::arg("spacing"),
          "Corners [m] and triangles of the surface of the solid that particles at x fill.");
}

}  // namespace perimpm::python
