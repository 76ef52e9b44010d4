// Compiles a device's programs, or takes them from the cache, and retains them.
#include "gl/programs.h"

#include "base/status.h"
#include "gl/program_cache.h"

#include <assert.h>
#include <string.h>

enum
{
    qc_maxStages = 2,
    qc_maxLog = 256
};

static const char* StageName(GLenum stage)
{
    return stage == GL_VERTEX_SHADER ? "vertex" : stage == GL_FRAGMENT_SHADER ? "fragment" : "compute";
}

/// Whether GL has compiled a shader, or linked a program; otherwise the beginning of its log. `query`:
/// GL_COMPILE_STATUS or GL_LINK_STATUS.
static bool HasSucceeded(GLuint object, GLenum query, PFNGLGETSHADERIVPROC getValue, PFNGLGETSHADERINFOLOGPROC getLog,
                         char log[qc_maxLog])
{
    GLint succeeded = GL_FALSE;
    getValue(object, query, &succeeded);
    if (succeeded == GL_TRUE)
        return true;
    log[0] = 0;
    getLog(object, qc_maxLog, NULL, log);
    return false;
}

static qcStatus CompileShader(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* source,
                              GLuint* shader)
{
    *shader = gl->CreateShader(source->stage);
    gl->ShaderSource(*shader, source->partCount, source->parts, NULL);
    gl->CompileShader(*shader);
    char log[qc_maxLog];
    if (HasSucceeded(*shader, GL_COMPILE_STATUS, gl->GetShaderiv, gl->GetShaderInfoLog, log))
        return qc_statusOk;
    return qcFail(qc_statusDevice, "%s: the %s shader does not compile: %s", name, StageName(source->stage), log);
}

/// Shaders that become one program.
typedef struct Recipe
{
    const char* name;
    const qcShaderSource* sources;
    int sourceCount;
    qcProgramKey key;
} Recipe;

static qcStatus LinkProgram(const struct qcGlFunctions* gl, const Recipe* recipe, const GLuint* shaders,
                            GLuint* program)
{
    *program = gl->CreateProgram();
    for (int i = 0; i < recipe->sourceCount; i++)
        gl->AttachShader(*program, shaders[i]);
    gl->BindAttribLocation(*program, 0, "position");
    gl->BindAttribLocation(*program, 1, "normal");
    qcProgramCache_Announce(gl, &recipe->key, *program);
    gl->LinkProgram(*program);
    char log[qc_maxLog];
    if (HasSucceeded(*program, GL_LINK_STATUS, gl->GetProgramiv, gl->GetProgramInfoLog, log))
        return qc_statusOk;
    gl->DeleteProgram(*program);
    return qcFail(qc_statusDevice, "%s: the program does not link: %s", recipe->name, log);
}

/// A linked program keeps what it needs of its shaders.
static qcStatus CompileProgram(const struct qcGlFunctions* gl, const Recipe* recipe, GLuint* program)
{
    GLuint shaders[qc_maxStages] = {0};
    qcStatus status = qc_statusOk;
    for (int i = 0; i < recipe->sourceCount && status == qc_statusOk; i++)
        status = CompileShader(gl, recipe->name, &recipe->sources[i], &shaders[i]);
    if (status == qc_statusOk)
        status = LinkProgram(gl, recipe, shaders, program);
    for (int i = 0; i < recipe->sourceCount; i++)
        gl->DeleteShader(shaders[i]); // zero is ignored
    if (status == qc_statusOk)
        qcProgramCache_Store(gl, &recipe->key, *program);
    return status;
}

/// The program of this name, or 0.
static GLuint FindProgram(const struct qcGlFunctions* gl, const char* name)
{
    const struct qcGlPrograms* programs = gl->programs;
    for (uint32_t i = 0; i < programs->count; ++i)
        if (strcmp(programs->items[i].name, name) == 0)
            return programs->items[i].program;
    return 0;
}

/// Makes a program and retains it.
static qcStatus MakeProgram(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* sources,
                            int sourceCount, GLuint* program)
{
    struct qcGlPrograms* programs = gl->programs;
    Recipe recipe = {.name = name, .sources = sources, .sourceCount = sourceCount};
    assert(programs->count < qc_maxPrograms && sourceCount <= qc_maxStages);
    qcStatus status = qcProgramKey_Make(gl, name, sources, sourceCount, &recipe.key);
    *program = status == qc_statusOk ? qcProgramCache_Load(gl, &recipe.key) : 0;
    if (status == qc_statusOk && *program == 0)
        status = CompileProgram(gl, &recipe, program);
    qcProgramKey_Free(&recipe.key);
    if (status == qc_statusOk)
    {
        programs->items[programs->count].name = name;
        programs->items[programs->count].program = *program;
        ++programs->count;
    }
    return status;
}

qcStatus qcGlPrograms_Get(const struct qcGlFunctions* gl, const char* name, const char* vertexSource,
                          const char* fragmentSource, GLuint* program)
{
    *program = FindProgram(gl, name);
    if (*program != 0)
        return qc_statusOk;
    const qcShaderSource sources[] = {{GL_VERTEX_SHADER, &vertexSource, 1}, {GL_FRAGMENT_SHADER, &fragmentSource, 1}};
    return MakeProgram(gl, name, sources, 2, program);
}

qcStatus qcGlPrograms_GetCompute(const struct qcGlFunctions* gl, const char* name, const char* const* sources,
                                 int sourceCount, GLuint* program)
{
    *program = FindProgram(gl, name);
    if (*program != 0)
        return qc_statusOk;
    const qcShaderSource source = {GL_COMPUTE_SHADER, sources, sourceCount};
    return MakeProgram(gl, name, &source, 1, program);
}
