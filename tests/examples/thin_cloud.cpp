// Thins a point cloud to so many of its own points, evenly spread; all properties of these are
// kept, and each says how many points it stands for.
//   g++ -std=c++20 -O2 thin_cloud.cpp $(pkg-config --cflags --libs ccvt) -o thin_cloud
//   ./thin_cloud scan.ply 2000 thinned.ply
#include <ccvt/ccvt.h>

#include <exception>
#include <iostream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: thin_cloud CLOUD NUMBER THINNED\n";
    return 2;
  }
  try {
    const ccvt::PointCloud cloud = ccvt::read_point_cloud(argv[1]);
    // Where the file has normals, points that face away from each other are kept apart.
    const ccvt::Thinning few =
        ccvt::thin(cloud.points, std::stoi(argv[2]), /*options=*/{}, cloud.normals);
    ccvt::write_point_cloud(argv[3], cloud, few.chosen, few.counts);
    std::cout << few.chosen.size() << " of " << cloud.points.cols() << " points, " << few.spacing
              << " apart if they were packed as densely as can be\n";
  } catch (const std::exception& error) {  // one line: what is wrong, with which file or argument
    std::cerr << "thin_cloud: " << error.what() << "\n";
    return 1;
  }
}
