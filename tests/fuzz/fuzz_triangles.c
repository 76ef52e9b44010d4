// Two triangles with snapped coordinates: their relation against rational arithmetic.
#include "fuzz/fuzz.h"
#include "support/oracle.h"
#include "triangle/exact.h"

#include <math.h>

static double TakeCoordinate(FuzzBytes* bytes)
{
    return (double)(int)Fuzz_TakeBelow(bytes, 9) - 4;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    FuzzBytes bytes = {data, size};
    double t[2][3][3];
    for (int i = 0; i < 18; i++)
        t[i / 9][i / 3 % 3][i % 3] = TakeCoordinate(&bytes);
    FUZZ_CHECK(qcExact_Relate(t[0], t[1], NULL) == qcOracle_Relate(t[0], t[1]));
    return 0;
}
