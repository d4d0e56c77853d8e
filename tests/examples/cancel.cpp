// A run that is watched, and stopped by another thread. What it has reached is valid: every site
// owns as many points as it should.
//   g++ -std=c++20 -O2 cancel.cpp $(pkg-config --cflags --libs ccvt) -o cancel -pthread
//   ./cancel
#include <ccvt/ccvt.h>

#include <algorithm>
#include <atomic>
#include <iostream>
#include <thread>
#include <vector>

int main() {
  const auto points = ccvt::sample_uniform<float, 2>(ccvt::Box::unit(2), 4'000'000, /*seed=*/1);

  // Stands for a button: pressed as soon as a tenth of the work is done.
  std::atomic<bool> tenth_done = false, pressed = false;
  std::jthread user([&] {
    tenth_done.wait(false);
    pressed = true;
  });

  double shown = 0;
  ccvt::Options options;
  options.on_iteration = [&](const ccvt::IterationRecord& record) {
    if (record.progress >= shown + 0.02) {
      shown = record.progress;
      std::cout << "progress " << shown << ", energy " << record.energy << "\n";
    }
    if (record.progress >= 0.1) {
      tenth_done = true;
      tenth_done.notify_one();
    }
    return true;  // false would cancel, too
  };
  options.cancelled = [&] { return pressed.load(); };  // asked several times a second
  const auto result = ccvt::tessellate(points, 4000, options);

  std::vector<int> owned(4000);
  for (const ccvt::Index owner : result.owners) ++owned[static_cast<std::size_t>(owner)];
  const auto [fewest, most] = std::minmax_element(owned.begin(), owned.end());
  std::cout << "ended: " << ccvt::to_string(result.summary.termination) << "; every site owns "
            << *fewest << " to " << *most << " points\n";
}
