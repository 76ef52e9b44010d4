// Counts what the functions of a device's thread make, and deletes what is left.
#include "gl/shared_names.h"

#include "base/status.h"

enum
{
    // More than a scene of some dozens of bodies has.
    qc_firstNames = 256
};

static const char s_purpose[] = "names of GL objects";

/// Those of the thread's device.
static _Thread_local qcSharedNames* s_names;

static void Note(qcNameKind kind, GLsizei count, const GLuint* made)
{
    qcArray* names = &s_names->names[kind];
    if (qcArray_Reserve(names, names->count + (size_t)count, sizeof(GLuint), s_purpose) != qc_statusOk)
        return;
    for (GLsizei i = 0; i < count; i++)
        QC_AT(GLuint, *names, names->count++) = made[i];
}

/// The last ones made are mostly the first ones deleted. Names that are 0 or of others are passed over.
static void Forget(qcNameKind kind, GLsizei count, const GLuint* deleted)
{
    qcArray* names = &s_names->names[kind];
    for (GLsizei i = 0; i < count; i++)
    {
        size_t at = names->count;
        while (at > 0 && QC_AT(GLuint, *names, at - 1) != deleted[i])
            at--;
        if (at > 0)
            QC_AT(GLuint, *names, at - 1) = QC_AT(GLuint, *names, --names->count);
    }
}

/// Functions of names in arrays, which make and delete objects of a kind.
#define QC_NOTING(kind, Make, Drop)                                                                                    \
    static void APIENTRY Make(GLsizei count, GLuint* made)                                                             \
    {                                                                                                                  \
        s_names->driver.Make(count, made);                                                                             \
        Note(kind, count, made);                                                                                       \
    }                                                                                                                  \
    static void APIENTRY Drop(GLsizei count, const GLuint* names)                                                      \
    {                                                                                                                  \
        s_names->driver.Drop(count, names);                                                                            \
        Forget(kind, count, names);                                                                                    \
    }

QC_NOTING(qc_nameBuffer, GenBuffers, DeleteBuffers)
QC_NOTING(qc_nameTexture, GenTextures, DeleteTextures)
QC_NOTING(qc_nameRenderbuffer, GenRenderbuffers, DeleteRenderbuffers)
QC_NOTING(qc_nameMemory, CreateMemoryObjects, DeleteMemoryObjects)

static GLuint APIENTRY CreateProgram(void)
{
    GLuint made = s_names->driver.CreateProgram();
    Note(qc_nameProgram, 1, &made);
    return made;
}

static void APIENTRY DeleteProgram(GLuint name)
{
    s_names->driver.DeleteProgram(name);
    Forget(qc_nameProgram, 1, &name);
}

static void Delete(const struct qcGlFunctions* driver, qcNameKind kind, GLuint name)
{
    switch (kind)
    {
        case qc_nameBuffer: driver->DeleteBuffers(1, &name); break;
        case qc_nameTexture: driver->DeleteTextures(1, &name); break;
        case qc_nameRenderbuffer: driver->DeleteRenderbuffers(1, &name); break;
        case qc_nameProgram: driver->DeleteProgram(name); break;
        case qc_nameMemory: driver->DeleteMemoryObjects(1, &name); break;
        case qc_nameKindCount: break;
    }
}

void qcSharedNames_DeleteAll(qcSharedNames* names)
{
    for (int kind = 0; kind < qc_nameKindCount; kind++)
    {
        qcArray* list = &names->names[kind];
        for (size_t i = 0; i < list->count; i++)
            Delete(&names->driver, (qcNameKind)kind, QC_AT(GLuint, *list, i));
        qcArray_Free(list);
    }
}

static qcStatus ReserveFirst(qcSharedNames* names)
{
    for (int kind = 0; kind < qc_nameKindCount; kind++)
        QC_TRY(qcArray_Reserve(&names->names[kind], qc_firstNames, sizeof(GLuint), s_purpose));
    return qc_statusOk;
}

qcStatus qcSharedNames_Watch(qcSharedNames* names, struct qcGlFunctions* gl)
{
    *names = (qcSharedNames){.driver = *gl};
    qcStatus status = ReserveFirst(names);
    if (status != qc_statusOk)
    {
        qcSharedNames_DeleteAll(names);
        return status;
    }
    s_names = names;
    gl->GenBuffers = GenBuffers;
    gl->DeleteBuffers = DeleteBuffers;
    gl->GenTextures = GenTextures;
    gl->DeleteTextures = DeleteTextures;
    gl->GenRenderbuffers = GenRenderbuffers;
    gl->DeleteRenderbuffers = DeleteRenderbuffers;
    gl->CreateProgram = CreateProgram;
    gl->DeleteProgram = DeleteProgram;
    if (gl->CreateMemoryObjects != NULL)
    {
        gl->CreateMemoryObjects = CreateMemoryObjects;
        gl->DeleteMemoryObjects = DeleteMemoryObjects;
    }
    return qc_statusOk;
}
