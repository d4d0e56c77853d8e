// A photograph (PNG or JPEG) as equal dots: FOLDER/dots.svg for print, FOLDER/dots.png to look at.
//   g++ -std=c++20 -O2 stipple.cpp $(pkg-config --cflags --libs ccvt) -o stipple
//   ./stipple photo.jpg 20000 FOLDER
#include <ccvt/ccvt.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: stipple PHOTO DOTS FOLDER\n";
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[3];
    std::filesystem::create_directories(folder);
    const auto dots = ccvt::stipple(ccvt::read_image(argv[1]), std::stoi(argv[2]));
    ccvt::write_svg(folder / "dots.svg", dots);
    ccvt::write_png(folder / "dots.png", ccvt::render(dots));  // enlarged until dots are round
    std::cout << dots.dots.cols() << " dots of radius " << dots.dot_radius << " pixels; "
              << dots.summary.brief() << "\n";
  } catch (const std::exception& error) {  // one line: what is wrong, with which file or argument
    std::cerr << "stipple: " << error.what() << "\n";
    return 1;
  }
}
