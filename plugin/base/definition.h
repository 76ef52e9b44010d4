// Definitions of the public API (qcBodyDef, ...) of this version and of others: structs whose first field is
// structSize.
#ifndef QC_BASE_DEFINITION_H
#define QC_BASE_DEFINITION_H

#include "quickcullide/base.h"

/// The layout of a definition in this version.
typedef struct qcDefLayout
{
    const char *function, *type; ///< named in messages
    size_t minSize;              ///< bytes, up to the end of the first field after structSize
    size_t size;                 ///< bytes, all of it
} qcDefLayout;

/// A qcDefLayout of `Type`, whose first field after structSize is `first`.
#define QC_DEF_LAYOUT(function, Type, first)                                                                           \
    ((qcDefLayout){function, #Type, offsetof(Type, first) + sizeof(((Type*)NULL)->first), sizeof(Type)})

/// Copies the caller's definition over `taken`, which holds this version's defaults.
/// - A smaller structSize: the fields beyond it keep their defaults.
/// - A larger one: accepted if all bytes beyond this version's size are 0, which means the default there too.
/// qc_statusBadInput leaves `taken` unchanged: structSize is below minSize, not a multiple of 4 or more than 256 bytes
/// larger, or a byte beyond this version's size isn't 0. A new field starts at or after the struct's previous size,
/// never in its padding.
qcStatus qcDef_Take(const void* def, qcDefLayout layout, void* taken);

#endif
