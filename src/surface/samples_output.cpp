#include <cstddef>
#include <string>
#include <vector>

#include "ccvt/surface.h"
#include "io/sample_table.h"

namespace ccvt {

void write_samples(const std::filesystem::path& path, const SurfaceSamples& samples) {
  const auto columns = [](const Columns<double>& values) {
    return std::span<const double>(values.data(), static_cast<std::size_t>(values.size()));
  };
  if (samples.barycentric.cols() > 0 && samples.barycentric.rows() != 3) {
    throw InvalidInput("samples: barycentric has " + std::to_string(samples.barycentric.rows()) +
                       " rows; needs 3");
  }
  std::vector<double> uv;
  for (std::ptrdiff_t s = 0; s < samples.barycentric.cols(); ++s) {
    uv.insert(uv.end(), {samples.barycentric(1, s), samples.barycentric(2, s)});
  }
  io::write_sample_table(path, {samples.sites,
                                samples.radii,
                                samples.scalar,
                                {{"normal", {"nx", "ny", "nz"}, columns(samples.normals)},
                                 {"radius", samples.radii},
                                 {"capacity", samples.capacities},
                                 {"weight", samples.weights},
                                 {"triangle", samples.triangles},
                                 {"uv", {"u", "v"}, uv}}});
}

}  // namespace ccvt
