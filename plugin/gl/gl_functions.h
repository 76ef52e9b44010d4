// The GL functions of one device, and the state of its context. epoxy's headers give the types and the enums; its
// functions are never called: they abort the process where libEGL is missing, and with an OSMesa context.
#ifndef QC_GL_GL_FUNCTIONS_H
#define QC_GL_GL_FUNCTIONS_H

#include "quickcullide/base.h"

#include <epoxy/gl.h>

/// The functions that a job may call: type, name without "gl". All are in GL 3.3 core.
#define QC_GL_FUNCTIONS(X)                                                                                             \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                                           \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                                             \
    X(PFNGLBEGINQUERYPROC, BeginQuery)                                                                                 \
    X(PFNGLBINDATTRIBLOCATIONPROC, BindAttribLocation)                                                                 \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                                 \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                                                         \
    X(PFNGLBINDBUFFERRANGEPROC, BindBufferRange)                                                                       \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                                       \
    X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                                                                     \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                                                               \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                                       \
    X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                                                                       \
    X(PFNGLBUFFERDATAPROC, BufferData)                                                                                 \
    X(PFNGLBUFFERSUBDATAPROC, BufferSubData)                                                                           \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                                         \
    X(PFNGLCLEARPROC, Clear)                                                                                           \
    X(PFNGLCLEARCOLORPROC, ClearColor)                                                                                 \
    X(PFNGLCLIENTWAITSYNCPROC, ClientWaitSync)                                                                         \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                                           \
    X(PFNGLCOPYBUFFERSUBDATAPROC, CopyBufferSubData)                                                                   \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                                           \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                                             \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                                           \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                                                 \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                                           \
    X(PFNGLDELETEQUERIESPROC, DeleteQueries)                                                                           \
    X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                                                               \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                                             \
    X(PFNGLDELETESYNCPROC, DeleteSync)                                                                                 \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                                         \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                                                 \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                                                                   \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                                                                   \
    X(PFNGLDEPTHRANGEPROC, DepthRange)                                                                                 \
    X(PFNGLDISABLEPROC, Disable)                                                                                       \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                                 \
    X(PFNGLDRAWBUFFERPROC, DrawBuffer)                                                                                 \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                                                                             \
    X(PFNGLENABLEPROC, Enable)                                                                                         \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                                       \
    X(PFNGLENDQUERYPROC, EndQuery)                                                                                     \
    X(PFNGLFENCESYNCPROC, FenceSync)                                                                                   \
    X(PFNGLFINISHPROC, Finish)                                                                                         \
    X(PFNGLFLUSHPROC, Flush)                                                                                           \
    X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)                                                       \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                                                             \
    X(PFNGLFRONTFACEPROC, FrontFace)                                                                                   \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                                                                 \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                                       \
    X(PFNGLGENQUERIESPROC, GenQueries)                                                                                 \
    X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                                                                     \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                                                               \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                                       \
    X(PFNGLGETBUFFERPARAMETERI64VPROC, GetBufferParameteri64v)                                                         \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)                                                                     \
    X(PFNGLGETERRORPROC, GetError)                                                                                     \
    X(PFNGLGETINTEGER64VPROC, GetInteger64v)                                                                           \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                                                               \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                                   \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                             \
    X(PFNGLGETQUERYIVPROC, GetQueryiv)                                                                                 \
    X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                                                               \
    X(PFNGLGETQUERYOBJECTUIVPROC, GetQueryObjectuiv)                                                                   \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                                     \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                               \
    X(PFNGLGETSTRINGPROC, GetString)                                                                                   \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                                 \
    X(PFNGLISBUFFERPROC, IsBuffer)                                                                                     \
    X(PFNGLISSYNCPROC, IsSync)                                                                                         \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                               \
    X(PFNGLMAPBUFFERRANGEPROC, MapBufferRange)                                                                         \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                                               \
    X(PFNGLPOLYGONMODEPROC, PolygonMode)                                                                               \
    X(PFNGLPOLYGONOFFSETPROC, PolygonOffset)                                                                           \
    X(PFNGLQUERYCOUNTERPROC, QueryCounter)                                                                             \
    X(PFNGLREADBUFFERPROC, ReadBuffer)                                                                                 \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                                                                 \
    X(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage)                                                               \
    X(PFNGLRENDERBUFFERSTORAGEMULTISAMPLEPROC, RenderbufferStorageMultisample)                                         \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                             \
    X(PFNGLTEXBUFFERPROC, TexBuffer)                                                                                   \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                                                                 \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                                           \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                                   \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                                                                   \
    X(PFNGLUNIFORM1UIPROC, Uniform1ui)                                                                                 \
    X(PFNGLUNIFORM2UIPROC, Uniform2ui)                                                                                 \
    X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                                                                 \
    X(PFNGLUNIFORM4FVPROC, Uniform4fv)                                                                                 \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                                                     \
    X(PFNGLUNMAPBUFFERPROC, UnmapBuffer)                                                                               \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                                 \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                                                               \
    X(PFNGLVIEWPORTPROC, Viewport)

/// What is known of the context's state, and of the present job.
struct qcGlState
{
    /// The object whose bindings of buffers and textures are current, see qcGl_KeepBindings; null: none.
    const void* bound;
    bool keepBindings; ///< the present job calls no function whose effect has to be reset
    bool isAnswered;   ///< the present job has read what its last kernel wrote: its context was not lost before
    bool hasNoErrors;  ///< what the present job has read shows that none of its calls failed
    uint32_t calls;    ///< calls counted by qcGl_Counted
};

struct qcGlFunctions
{
#define QC_GL_FIELD(Type, Name) Type Name;
    QC_GL_FUNCTIONS(QC_GL_FIELD)
#undef QC_GL_FIELD
    /// Null below GL 4.5.
    PFNGLGETGRAPHICSRESETSTATUSPROC GetGraphicsResetStatus;
    /// Compute shaders and clearing of buffers; all null below GL 4.3.
    PFNGLCLEARBUFFERDATAPROC ClearBufferData;
    PFNGLDISPATCHCOMPUTEPROC DispatchCompute;
    PFNGLMEMORYBARRIERPROC MemoryBarrier;
    /// Null below GL 4.4 without ARB_buffer_storage.
    PFNGLBUFFERSTORAGEPROC BufferStorage;
    /// All null below GL 4.1 without ARB_get_program_binary.
    PFNGLGETPROGRAMBINARYPROC GetProgramBinary;
    PFNGLPROGRAMBINARYPROC ProgramBinary;
    PFNGLPROGRAMPARAMETERIPROC ProgramParameteri;
    /// GL_EXT_memory_object_fd; all null without it.
    PFNGLCREATEMEMORYOBJECTSEXTPROC CreateMemoryObjects;
    PFNGLDELETEMEMORYOBJECTSEXTPROC DeleteMemoryObjects;
    PFNGLMEMORYOBJECTPARAMETERIVEXTPROC MemoryObjectParameteriv;
    PFNGLIMPORTMEMORYFDEXTPROC ImportMemoryFd;
    PFNGLBUFFERSTORAGEMEMEXTPROC BufferStorageMem;
    struct qcGlPrograms* programs;
    struct qcGlState* state;
};

/// For a job that leaves all bindings and switches at their initial values, except for the program, indexed bindings of
/// buffers, buffer textures, and the targets of computing and copying: these stay for the next job of `owner`, and no
/// state is reset after the job.
static inline void qcGl_KeepBindings(const struct qcGlFunctions* gl, const void* owner)
{
    gl->state->bound = owner;
    gl->state->keepBindings = true;
}

/// Counts the call that follows: qcGl_Counted(gl)->UseProgram(program).
static inline const struct qcGlFunctions* qcGl_Counted(const struct qcGlFunctions* gl)
{
    gl->state->calls++;
    return gl;
}

/// "GL_INVALID_ENUM"; "a GL error" for values that GL doesn't define.
const char* qcGl_ErrorName(GLenum error);
/// qc_statusDevice if a call has failed since the last check; the message is the formatted text and the error.
__attribute__((format(printf, 2, 3))) qcStatus qcGl_CheckError(const struct qcGlFunctions* gl, const char* format, ...);

typedef void qcGlFunction(void);
/// eglGetProcAddress or OSMesaGetProcAddress.
typedef qcGlFunction* qcGlGetFunction(const char* name);

/// Whether the current context has an extension. A function may exist for a name that the driver doesn't support.
bool qcGl_HasExtension(qcGlGetFunction* getFunction, const char* name);

/// Fills the functions. qc_statusDevice names the first that is missing.
qcStatus qcGlFunctions_Load(struct qcGlFunctions* gl, qcGlGetFunction* getFunction);

/// Restores GL's initial bindings and switches, as far as jobs change them. Values such as the viewport and the clear
/// colour are not restored: each job sets those it uses.
void qcGlFunctions_ResetState(const struct qcGlFunctions* gl);

#endif
