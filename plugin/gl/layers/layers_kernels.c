// Compiles and dispatches the compute kernels of `layers`.
#include "gl/layers/layers_kernels.h"

#include "base/status.h"
#include "layers_shaders.h"

#include <stddef.h>
#include <stdio.h>

enum
{
    qc_maxOutputs = 5
};

typedef struct KernelShape
{
    const char* name;
    const char* imageName; ///< of the variant for the image only; null: there is none
    const char* source;
    int localSize;              ///< invocations of a workgroup; small where items are few, so that all threads get some
    int outputs[qc_maxOutputs]; ///< storage blocks 1, 2, ...; qc_layersBufferCount: no more
} KernelShape;

static const KernelShape s_shapes[qc_kernelCount] = {
    [qc_kernelVertices] = {"layers, vertices", NULL, s_layersVertices, 64, {qc_layersVertices, qc_layersBufferCount}},
    [qc_kernelBoxes] = {"layers, boxes",
                        "layers, groups",
                        s_layersBoxes,
                        64,
                        {qc_workBoxes, qc_workClusterBoxes, qc_layersBufferCount}},
    [qc_kernelNodes] = {"layers, nodes",
                        "layers, nodes and groups",
                        s_layersNodes,
                        16,
                        {qc_workNodeBoxes, qc_workHeads, qc_workEntries, qc_workNodePairs, qc_workNodeGroups}},
    [qc_kernelNodePairs] =
        {"layers, node pairs", NULL, s_layersNodePairs, 16, {qc_workNodePairs, qc_layersBufferCount}},
    [qc_kernelClusterPairs] = {"layers, cluster pairs",
                               NULL,
                               s_layersClusterPairs,
                               16,
                               {qc_workClusterPairs, qc_workNodePairTables, qc_layersBufferCount}},
    [qc_kernelTrianglePairs] =
        {"layers, triangle pairs", NULL, s_layersTrianglePairs, 64, {qc_workTrianglePairs, qc_layersBufferCount}},
    [qc_kernelFilter] = {"layers, filter", NULL, s_layersFilter, 64, {qc_workSurvivors, qc_layersBufferCount}},
};

/// GLSL types of the uniforms.
typedef enum UniformType
{
    type_uint,
    type_uvec3,
    type_float,
    type_vec3,
    type_vec4
} UniformType;

static const struct
{
    const char* name;
    UniformType type;
    size_t offset; ///< in qcLayersUniforms
} s_uniforms[] = {
    {"chunkCount", type_uint, offsetof(qcLayersUniforms, chunkCount)},
    {"nodeCount", type_uint, offsetof(qcLayersUniforms, nodeCount)},
    {"entryCapacity", type_uint, offsetof(qcLayersUniforms, entryCapacity)},
    {"nodePairCapacity", type_uint, offsetof(qcLayersUniforms, nodePairCapacity)},
    {"clusterPairCapacity", type_uint, offsetof(qcLayersUniforms, clusterPairCapacity)},
    {"trianglePairCapacity", type_uint, offsetof(qcLayersUniforms, trianglePairCapacity)},
    {"survivorCapacity", type_uint, offsetof(qcLayersUniforms, survivorCapacity)},
    {"testNeighbours", type_uint, offsetof(qcLayersUniforms, testNeighbours)},
    {"runNumber", type_uint, offsetof(qcLayersUniforms, runNumber)},
    {"cellShift", type_uvec3, offsetof(qcLayersUniforms, cellShift)},
    {"scale", type_vec3, offsetof(qcLayersUniforms, scale)},
    {"slack", type_vec4, offsetof(qcLayersUniforms, slack)},
    {"pointError", type_float, offsetof(qcLayersUniforms, pointError)},
    {"queryDistance", type_float, offsetof(qcLayersUniforms, queryDistance)},
};
_Static_assert(sizeof s_uniforms / sizeof s_uniforms[0] == qc_uniformCount, "a location for each uniform");

/// The constants of a program, as its first source.
static void WriteConstants(char* text, size_t size, const KernelShape* shape, bool imageVariant)
{
    snprintf(text, size,
             "#version 430 core\n%s#define BODY_TEXELS %d\n#define GROUPS_IN_ROW %du\n#define LOCAL_SIZE %d\n"
             "#define CONSUMER_SIZES uint[4](%du, %du, %du, %du)\n",
             imageVariant ? "#define IMAGE_ONLY\n" : "", qc_layersBodyTexels, qc_groupsInRow, shape->localSize,
             s_shapes[qc_kernelNodePairs].localSize, s_shapes[qc_kernelClusterPairs].localSize,
             s_shapes[qc_kernelTrianglePairs].localSize, s_shapes[qc_kernelFilter].localSize);
}

static qcStatus GetProgram(const struct qcGlFunctions* gl, qcLayersKernels* kernels, int kernel)
{
    const KernelShape* shape = &s_shapes[kernel];
    bool imageVariant = kernels->imageOnly && shape->imageName != NULL;
    char constants[256];
    WriteConstants(constants, sizeof constants, shape, imageVariant);
    const char* sources[] = {constants, s_layersCommon, shape->source};
    GLuint program;
    QC_TRY(qcGlFunctions_GetComputeProgram(gl, imageVariant ? shape->imageName : shape->name, sources, 3, &program));
    kernels->programs[kernel] = program;
    gl->UseProgram(program);
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        if (qcLayersBuffers_SamplerName(buffer) != NULL)
            gl->Uniform1i(gl->GetUniformLocation(program, qcLayersBuffers_SamplerName(buffer)), buffer);
    for (int i = 0; i < qc_uniformCount; i++)
        kernels->uniforms[kernel][i] = gl->GetUniformLocation(program, s_uniforms[i].name);
    return qc_statusOk;
}

qcStatus qcLayersKernels_Create(const struct qcGlFunctions* gl, qcLayersKernels* kernels)
{
    if (gl->DispatchCompute == NULL)
        return qcFail(qc_statusDevice, "layers: the device has no compute shaders (GL below 4.3)");
    int count = kernels->imageOnly ? qc_kernelNodes + 1 : qc_kernelCount;
    for (int kernel = 0; kernel < count; kernel++)
        QC_TRY(GetProgram(gl, kernels, kernel));
    return qc_statusOk;
}

static void SetUniform(const struct qcGlFunctions* gl, GLint location, UniformType type, const void* value)
{
    const uint32_t* u = value;
    switch (type)
    {
        case type_uint: gl->Uniform1ui(location, u[0]); break;
        case type_uvec3: gl->Uniform3ui(location, u[0], u[1], u[2]); break;
        case type_float: gl->Uniform1f(location, *(const float*)value); break;
        case type_vec3: gl->Uniform3fv(location, 1, value); break;
        case type_vec4: gl->Uniform4fv(location, 1, value); break;
    }
}

/// Selects a kernel for the next dispatch.
static void Use(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, const qcLayersBuffers* b,
                qcLayersKernel kernel, const qcLayersUniforms* values)
{
    const KernelShape* shape = &s_shapes[kernel];
    gl->UseProgram(kernels->programs[kernel]);
    for (GLuint i = 0; i < qc_maxOutputs && shape->outputs[i] != qc_layersBufferCount; i++)
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i + 1, b->buffers[shape->outputs[i]]);
    for (int i = 0; i < qc_uniformCount; i++)
        if (kernels->uniforms[kernel][i] >= 0)
            SetUniform(gl, kernels->uniforms[kernel][i], s_uniforms[i].type,
                       (const char*)values + s_uniforms[i].offset);
}

static void Finish(const struct qcGlFunctions* gl)
{
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      GL_COMMAND_BARRIER_BIT);
}

void qcLayersKernels_Run(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, const qcLayersBuffers* b,
                         qcLayersKernel kernel, const qcLayersUniforms* values, uint64_t items)
{
    uint64_t localSize = (uint64_t)s_shapes[kernel].localSize, groups = (items + localSize - 1) / localSize;
    groups = groups > 0 ? groups : 1;
    Use(gl, kernels, b, kernel, values);
    gl->DispatchCompute((GLuint)(groups < qc_groupsInRow ? groups : qc_groupsInRow),
                        (GLuint)((groups + qc_groupsInRow - 1) / qc_groupsInRow), 1);
    Finish(gl);
}

void qcLayersKernels_RunIndirect(const struct qcGlFunctions* gl, const qcLayersKernels* kernels,
                                 const qcLayersBuffers* b, qcLayersKernel kernel, const qcLayersUniforms* values,
                                 size_t offset)
{
    Use(gl, kernels, b, kernel, values);
    gl->DispatchComputeIndirect((GLintptr)offset);
    Finish(gl);
}
