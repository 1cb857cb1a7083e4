# One object of several, with the names that the package promises and no others: what is inline or a template (Eigen's,
# the standard library's) must not be merged with the caller's, who compiles with other flags, nor OSQP with another OSQP.
#   cmake -DLINKER= -DOBJCOPY= -DNM= -DINPUTS=list -DARCHIVES=list -DBY_CALLER=bool -DTYPES=bool -DOUTPUT= -P isolate.cmake
# ARCHIVES: what the inputs need of them goes in, too. BY_CALLER: the inputs (not the archives) allocate by the functions of
# eigen_abi.hpp. TYPES: callers derive from its classes and catch its errors, so their type information is promised as well,
# and the types of the IDL, whose names are C's.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${error}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(whole ${OUTPUT}.whole)
run(${LINKER} -r --force-group-allocation -o ${whole} ${INPUTS})
if(BY_CALLER)
  set(renamed)
  foreach(function malloc calloc realloc free)
    list(APPEND renamed --redefine-sym ${function}=c3rt_${function})
  endforeach()
  run(${OBJCOPY} ${renamed} ${whole})
endif()
if(ARCHIVES)
  run(${LINKER} -r -o ${whole}.2 ${whole} ${ARCHIVES})
  file(RENAME ${whole}.2 ${whole})
endif()
run(${NM} --defined-only --extern-only --format=posix ${whole})
# a strong symbol of ours: code, data, constants, zeros; weak and unique ones (V, W, u) are what everybody has of his own
string(REGEX MATCHALL "_Z[A-Za-z0-9_]*4c3rt[A-Za-z0-9_.]* [TDRB] " promised "${output}")
if(TYPES)
  string(REGEX MATCHALL "_ZT[IS]N4c3rt[A-Za-z0-9_]* V |\nc3rt_[A-Za-z0-9_]+ [TDRB] " types "${output}")
  list(APPEND promised ${types})
endif()
string(REGEX REPLACE "\n| [TDRBV] " "" promised "${promised}")
list(JOIN promised "\n" promised)
file(WRITE ${OUTPUT}.names "${promised}\n")
string(REGEX MATCHALL "[A-Za-z0-9_.]+ u " unique "${output}")
string(REGEX REPLACE " u " "" unique "${unique}")
list(JOIN unique "\n" unique)
file(WRITE ${OUTPUT}.unique "${unique}\n")
run(${OBJCOPY} --weaken-symbols=${OUTPUT}.unique ${whole})  # of unique ones it makes no local ones
run(${OBJCOPY} --keep-global-symbols=${OUTPUT}.names ${whole} ${OUTPUT})
file(REMOVE ${whole})
