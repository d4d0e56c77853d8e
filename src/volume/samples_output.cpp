#include "ccvt/volume.h"
#include "io/sample_table.h"

namespace ccvt {

void write_samples(const std::filesystem::path& path, const VolumeSamples& samples) {
  io::write_sample_table(
      path,
      {samples.sites,
       samples.radii,
       samples.scalar,
       {{"radius", samples.radii}, {"capacity", samples.capacities}, {"weight", samples.weights}}});
}

}  // namespace ccvt
