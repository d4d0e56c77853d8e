# Run by ctest: makes a test of each doctest case of `program`, named "suite: case" and labelled
# with its suite. doctest's own doctest_discover_tests() asks the program once for each case, and
# stumbles over brackets in names.

if(NOT EXISTS ${program})  # who has built and runs others needs none of these
  add_test("${program} is not built" ${program})
  return()
endif()
execute_process(COMMAND ${program} --list-test-cases --reporters=xml
  OUTPUT_VARIABLE xml COMMAND_ERROR_IS_FATAL ANY)

string(REGEX MATCHALL "<TestCase " all "${xml}")
list(LENGTH all expected)
set(found 0)
while(xml MATCHES "<TestCase name=\"([^\"]*)\" testsuite=\"([^\"]*)\"")
  set(case "${CMAKE_MATCH_1}")
  set(suite "${CMAKE_MATCH_2}")
  string(FIND "${xml}" "${CMAKE_MATCH_0}" position)
  string(LENGTH "${CMAKE_MATCH_0}" length)
  math(EXPR position "${position} + ${length}")
  string(SUBSTRING "${xml}" ${position} -1 xml)

  string(REPLACE "&lt;" "<" case "${case}")
  string(REPLACE "&gt;" ">" case "${case}")
  string(REPLACE "&quot;" "\"" case "${case}")
  string(REPLACE "&amp;" "&" case "${case}")
  string(REPLACE "," "\\," filter "${case}")  # an unescaped comma separates filters

  add_test("${suite}: ${case}" ${program} "--test-suite=${suite}" "--test-case=${filter}")
  set_tests_properties("${suite}: ${case}" PROPERTIES
    LABELS "${suite}"
    TIMEOUT 600
    FAIL_REGULAR_EXPRESSION "test cases: +0 ")  # doctest takes no match for a success
  math(EXPR found "${found} + 1")
endwhile()
if(NOT found EQUAL expected)
  message(FATAL_ERROR "${expected} test cases, but only ${found} are in a test suite")
endif()
