# What of the library the linker of its users sees: names of ours, and nothing of Eigen, FLANN, TBB or
# the standard library, which a user's program compiled with other flags brings along itself.
#   cmake -D LIBRARY= -D NM= -P symbols.cmake
set(dynamic)
if(LIBRARY MATCHES "\\.so")
  set(dynamic --dynamic)
endif()
execute_process(COMMAND ${NM} ${dynamic} --defined-only --extern-only ${LIBRARY}
  OUTPUT_VARIABLE mangled COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${NM} ${dynamic} --demangle --defined-only --extern-only ${LIBRARY}
  OUTPUT_VARIABLE demangled COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[0-9a-f]+ [A-Za-z] [^\n]+" symbols "${mangled}")
list(LENGTH symbols count)
if(count LESS 50)
  message(FATAL_ERROR "${LIBRARY} shows ${count} symbols only: is this the library?")
endif()
# Tables and type information of the classes that users derive from are the library's.
foreach(class 5Ranks 15MessageProgress)
  foreach(kind TV TI TS)
    if(NOT mangled MATCHES " [VDR] _Z${kind}N4ccvt${class}E\n")
      message(SEND_ERROR "does not show _Z${kind}N4ccvt${class}E")
    endif()
    list(FILTER symbols EXCLUDE REGEX " [VDR] _Z${kind}N4ccvt${class}E$")
  endforeach()
endforeach()
foreach(symbol IN LISTS symbols)
  if(NOT symbol MATCHES "^[0-9a-f]+ [TW] _ZNK?R?4ccvt")
    message(SEND_ERROR "shows what is not an exported function of ccvt: ${symbol}")
  endif()
endforeach()
if(demangled MATCHES "[^\n]*(Eigen::|flann::|tbb::)[^\n]*")
  message(SEND_ERROR "an exported function takes, returns or is what it may not: ${CMAKE_MATCH_0}")
endif()
message(STATUS "${count} symbols, all of them ccvt's functions and tables, none with a type of Eigen")
