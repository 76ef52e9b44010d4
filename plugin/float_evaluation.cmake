# QC_FLOAT_EVALUATION: the option with which this compiler evaluates each operation in the type of its operands; an error
# where there is none.
include(CheckCSourceCompiles)
set(QC_FLOAT_PROGRAM "#include <float.h>
#if FLT_EVAL_METHOD != 0
#error operations are evaluated in a wider type
#endif
int main(void) { return 0; }")

set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
check_c_source_compiles("${QC_FLOAT_PROGRAM}" QC_FLOATS_ARE_EXACT)
if(NOT QC_FLOATS_ARE_EXACT)
  set(CMAKE_REQUIRED_FLAGS -fexcess-precision=fast)
  check_c_source_compiles("${QC_FLOAT_PROGRAM}" QC_FLOATS_ARE_EXACT_IF_FAST)
  unset(CMAKE_REQUIRED_FLAGS)
  if(NOT QC_FLOATS_ARE_EXACT_IF_FAST)
    message(FATAL_ERROR "This compiler evaluates floats or doubles in wider registers (x87), for which the proofs of \
Quick-CULLIDE don't hold. With gcc or clang on 32-bit x86: CFLAGS='-msse2 -mfpmath=sse'.")
  endif()
  set(QC_FLOAT_EVALUATION -fexcess-precision=fast)
endif()
unset(CMAKE_TRY_COMPILE_TARGET_TYPE)
