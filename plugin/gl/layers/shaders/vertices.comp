// New vertices, from chunks of 64 of a body, to positions in the grid frame. Resets the lists, and copies what later
// kernels read of the step's data to the device's memory: on a GPU each read of the processor's memory takes microseconds.
layout(std430, binding = 1) buffer Vertices { vec4 outVertices[]; };
layout(std430, binding = SOURCE_BINDING) readonly buffer Source { uint source[]; }; // another buffer with floats
#ifdef COPY_BINDING
layout(std430, binding = COPY_BINDING) writeonly buffer StepCopy { uint stepCopy[]; };
#endif
// xyz: bits of a position about the body's centre; w: the body's slot. Integer texels: a small integer read as a float is
// denormal, and GLSL allows denormals to become 0.
uniform usamplerBuffer locals;
uniform uvec2 foreignChunks; // chunks [x, y) of another buffer; 0: all chunks of the stream

const uint rigid = 0u, inFrame = 2u; // qcLayersChunkKind

void prepareLists()
{
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    for (uint i = ITEM; i < COUNTER_WORDS + listWords; i += stride)
        counters[i] = i >= COUNTER_WORDS ? EMPTY_LIST : i == kernelCounter ? kernelsOfRun(0u) : 0u;
    for (uint i = ITEM; i < bucketCount; i += stride)
        counters[bucketsAt + i] = 0u;
#ifdef COPY_BINDING
    for (uint i = ITEM; i < chunksAt; i += stride)
        stepCopy[i] = stepData[i];
#endif
}

vec3 transformed(int v)
{
    uvec4 bits = texelFetch(locals, v);
    vec3 local = uintBitsToFloat(bits.xyz), result;
    for (uint axis = 0u; axis < 3u; axis++)
    {
        vec4 row;
        for (uint i = 0u; i < 4u; i++)
            row[i] = uintBitsToFloat(bodyWord(bits.w, 8u + axis * 4u + i));
        result[axis] = dot(row.xyz, local) + row.w;
    }
    return result;
}

// A denormal float converts as an integer: GLSL allows it to become 0 otherwise.
double exactly(uint bits)
{
    if ((bits & 0x7f800000u) != 0u)
        return double(uintBitsToFloat(bits));
    double magnitude = double(bits & 0x7fffffu) * 1.4012984643248170709e-45LF;
    return (bits >> 31) != 0u ? -magnitude : magnitude;
}

uint floatBits(uint at)
{
    return foreignChunks.y != 0u ? source[at] : stepData[at];
}

shared uint packedWords[3 * LOCAL_SIZE];

// Vertices without gaps are read word by word: each word once, and those of neighbouring invocations together.
void readPacked(uint first, uint count, uint k)
{
    for (uint word = k; word < 3u * count; word += LOCAL_SIZE)
        packedWords[word] = floatBits(first + word);
}

uvec3 wordsOf(uint first, uint stride, uint k)
{
    if (stride == 3u)
        return uvec3(packedWords[3u * k], packedWords[3u * k + 1u], packedWords[3u * k + 2u]);
    uint at = first + k * stride;
    return uvec3(floatBits(at), floatBits(at + 1u), floatBits(at + 2u));
}

vec3 positionOf(uvec3 words, uint kind)
{
    if (kind == inFrame)
        return uintBitsToFloat(words);
    dvec3 world = dvec3(exactly(words[axes.x]), exactly(words[axes.y]), exactly(words[axes.z]));
    // In double: the origin may be far away, compared with the scene's extent.
    precise dvec3 offset = world - origin;
    return vec3(offset * unit);
}

void main()
{
    bool isForeign = foreignChunks.y != 0u;
    if (!isForeign)
        prepareLists();
    uint chunk = GROUP + foreignChunks.x, k = gl_LocalInvocationID.x, at = chunksAt + chunk * 4u;
    if (chunk >= (isForeign ? foreignChunks.y : chunkCount))
        return;

    uint first = stepData[at], count = stepData[at + 1u], kind = stepData[at + 3u] & 255u, stride = stepData[at + 3u] >> 8;
    uint firstWord = stepData[at + 2u] + (isForeign ? 0u : floatsAt);
    bool isRigid = kind == rigid;
    if (!isRigid && stride == 3u)
        readPacked(firstWord, count, k);
    barrier();
    if (k >= count)
        return;

    vec3 position = isRigid ? transformed(int(first + k)) : positionOf(wordsOf(firstWord, stride, k), kind);
    outVertices[first + k] = vec4(position, 0.0);
}
