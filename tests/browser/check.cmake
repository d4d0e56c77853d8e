# Makes a report, opens it in headless Chromium in frames of 400 and 1400 pixels, and checks that no
# picture is missing, no text cut off, and nothing said on the console. Screenshots stay in WORK_DIR.
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK_DIR} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

foreach(seed 1 2 3)
  run(${PROGRAM} sample --dim 2 --sites 200 --points-per-site 64 --periodic --seed ${seed} --quiet
    -o run${seed}.npy --points-out points${seed}.npy)
endforeach()
run(${PROGRAM} sample --dim 2 --sites 1 --points-per-site 300 --distribution white --quiet
  -o one.npy --points-out white.npy)
run(${PROGRAM} sample --dim 2 --sites 1 --points-per-site 256 --distribution square --quiet
  -o one.npy --points-out square.npy)
run(${PROGRAM} analyze run1.npy run2.npy run3.npy --periodic --quiet -o report
  --compare "a name of forty letters <&> ............=white.npy" square=square.npy)

file(READ ${WORK_DIR}/report/report.html page)
if(page MATCHES "(src|href)=\"[^d]")
  message(FATAL_ERROR "the page refers to something outside: ${CMAKE_MATCH_0}")
endif()
file(READ ${SOURCE_DIR}/check.js script)
string(REPLACE "</body>" "<script>${script}</script></body>" page "${page}")
file(WRITE ${WORK_DIR}/checked.html "${page}")

set(chromium ${CHROMIUM} --headless --no-sandbox --disable-gpu --hide-scrollbars
  --user-data-dir=${WORK_DIR}/profile)
foreach(width 400 1400)
  # In a frame, as no window is narrower than 500.
  file(WRITE ${WORK_DIR}/frame${width}.html "<!DOCTYPE html><meta charset=\"utf-8\">
<link rel=\"icon\" href=\"data:,\"><body style=\"margin:0\"><pre>nothing</pre>
<script>onmessage = (event) => document.querySelector('pre').textContent = event.data;</script>
<iframe src=\"checked.html\" style=\"border:0;width:${width}px;height:6000px\"></iframe></body>")
  execute_process(
    COMMAND ${chromium} --enable-logging=stderr --virtual-time-budget=5000 --dump-dom
      --window-size=1500,6000 file://${WORK_DIR}/frame${width}.html
    OUTPUT_VARIABLE document ERROR_VARIABLE log TIMEOUT 100 RESULT_VARIABLE result)
  string(REGEX MATCH "<pre>([^<]*)</pre>" found "${document}")
  set(verdict "${CMAKE_MATCH_1}")
  string(REGEX MATCHALL "[^\n]*CONSOLE[^\n]*" console "${log}")
  foreach(scheme 1 0)  # light, dark
    execute_process(
      COMMAND ${chromium} --window-size=${width},3000 --blink-settings=preferredColorScheme=${scheme}
        --screenshot=${WORK_DIR}/page${width}_${scheme}.png file://${WORK_DIR}/frame${width}.html
      OUTPUT_QUIET ERROR_QUIET TIMEOUT 100)
  endforeach()
  message(STATUS "${width} pixels: ${verdict}")
  if(NOT result EQUAL 0 OR NOT verdict MATCHES "^good: 3 images, 7 pictures$" OR console)
    message(FATAL_ERROR "${width} pixels: chromium ended with ${result}; page: ${verdict}; "
      "console: ${console}")
  endif()
endforeach()
