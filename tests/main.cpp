#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <hwy/targets.h>

#include "support/baseline.h"

int main(int count, char** arguments) {
  if (ccvt::test::asks_for_baseline()) hwy::SetSupportedTargetsForTest(HWY_STATIC_TARGET);
  return doctest::Context(count, arguments).run();
}
