// A translation of all objects of a world by the application.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_COMMON_SHIFT_H
#define QC_GLUE_MESH_CONTACT_LIMITS_COMMON_SHIFT_H

#include "mesh_contact/limits/swept_object.h"

/// A new origin of the world moves all objects by one translation, and none against another.
struct qcCommonShift
{
    btVector3 by{0, 0, 0}; ///< zero: there is none
    btScalar error = 0;    ///< of a displacement, by rounding

    /// The translation of all dynamic objects since the previous step.
    static qcCommonShift Find(const std::vector<qcSweptObject*>& objects);
    /// True if an object that was at `from` has moved by the translation alone.
    bool IsOf(const btTransform& from, const btTransform& to) const;
};

#endif
