// The extensible struct of openat2(2) and clone3(2), Linux.
#include "base/definition.h"

#include "base/status.h"

#include <string.h>

enum
{
    // Max bytes beyond this version's size that are checked. A larger structSize is taken for an uninitialised one.
    qc_maxExtraBytes = 256
};

static bool AreZero(const unsigned char* bytes, size_t count)
{
    unsigned char any = 0;
    for (size_t i = 0; i < count; i++)
        any |= bytes[i];
    return any == 0;
}

qcStatus qcDef_Take(const void* def, qcDefLayout layout, void* taken)
{
    uint32_t structSize;
    memcpy(&structSize, def, sizeof structSize);
    if (structSize < layout.minSize || structSize > layout.size + qc_maxExtraBytes || structSize % 4 != 0)
        return qcFail(qc_statusBadInput, "%s: structSize of %s is %u, expected %zu (start from its default function)",
                      layout.function, layout.type, structSize, layout.size);
    if (structSize > layout.size && !AreZero((const unsigned char*)def + layout.size, structSize - layout.size))
        return qcFail(qc_statusBadInput,
                      "%s: structSize of %s is %u, and a field that this version of the library doesn't have is set",
                      layout.function, layout.type, structSize);
    uint32_t size = (uint32_t)layout.size;
    memcpy(taken, def, structSize < size ? structSize : size);
    memcpy(taken, &size, sizeof size);
    return qc_statusOk;
}
