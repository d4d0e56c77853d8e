#include "cli/version_text.h"

#include "ccvt/build_info.h"
#include "io/formats.h"

namespace ccvt::cli {

std::string version_text() {
  const BuildInfo info = build_info();
  const auto formats = [&](io::Extensions extensions) {
    std::string list;
    for (const std::string_view extension : extensions) {
      if (extension == ".hdf5" && !info.hdf5) continue;
      list += " " + std::string(extension);
    }
    return list + "\n";
  };
  return "ccvt " + info.version + "\n" +                            //
         "compiler: " + info.compiler + "\n" +                      //
         "instruction set: " + info.instruction_set + ", here\n" +  //
         "threads: " + info.threads + "\n" +                        //
         "points from:" + formats(io::kPointFiles) +                //
         "sites to:" + formats(io::kSiteFiles) +                    //
         "volumes from:" + formats(io::kVolumeFiles) +              //
         "meshes from:" + formats(io::kMeshFiles) +                 //
         "samples to:" + formats(io::kSampleFiles) +                //
         "pictures from: .png .jpg\npictures to:" + formats(io::kPictureFiles);
}

}  // namespace ccvt::cli
