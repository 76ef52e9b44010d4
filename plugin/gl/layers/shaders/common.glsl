// Shared code of the kernels of `layers`. The README.md of gl/layers gives their order. Proof: plugin/docs/proofs/layers.md.
layout(local_size_x = LOCAL_SIZE) in;

// Uploaded when bodies are added.
uniform usamplerBuffer triangles;         // by slot: three vertices; x = none: no triangle
uniform usamplerBuffer nodes, links, tables;
// Made in this step.
uniform samplerBuffer vertices;           // in the frame; see gl/layers/layers_gpu.h
uniform usamplerBuffer clusterBoxes;

// COUNTER_WORDS, then for the image by cell its first entry, for pairs by tile of nodes its box, and the number of pairs in
// each bucket.
layout(std430, binding = 0) buffer Lists { uint counters[]; };
layout(std430, binding = STEP_BINDING) readonly buffer StepData { uint stepData[]; };

// qcLayersParameters of gl/layers/layers_kernels.h: the first PARAMETER_WORDS of the step's data.
layout(std140, binding = PARAMETER_BINDING) uniform Step
{
    uint chunkCount, changedNodes, activeNodes, runNumber;
    uint entryCapacity, nodePairCapacity, survivorCapacity, listWords;
    uint nodesAt, chunksAt, floatsAt; // words of the step's data, where bodies follow the parameters
    uint nodeBoxesAt;                 // boxes of the active nodes, in Boxes
    uvec3 cellShift; // the image's cells are pixels, each cut into slices of depth: 2^cellShift levels of each axis
    uint testNeighbours;
    vec3 scale;
    float pointError; // in the frame
    vec4 slack;       // levels; w: of the diagonal
    uvec3 axes;
    float queryDistance; // in the frame
    uint groupsAt;
    uint partsOfTile; // workgroups that compare one tile with others
    uint trianglePairCapacity;
    uint nodePairsOfGroup; // that a workgroup of triangle_pairs takes at a time
    dvec3 origin;
    double unit;
    uint bucketCount; // 0: the pairs of triangles stay in no order
    uint bucketShift; // a bucket has the pairs whose first triangles agree but for so many bits
    uint bucketsAt;   // word of Lists
};

const uint none = 0xffffffffu;

uint activeNode(uint i)
{
    return stepData[nodesAt + i];
}

uint bodyWord(uint body, uint word)
{
    return stepData[PARAMETER_WORDS + body * BODY_WORDS + word];
}

uint cellAt(uvec3 at)
{
    return (at.z << 15u - cellShift.y | at.y) << 15u - cellShift.x | at.x;
}

// One invocation per item: a loop over several items takes twice as long on llvmpipe.
#define GROUP (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x)
#define ITEM (GROUP * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

// Indices of the counters, each on a cache line of its own. finishedCounter gets the run's number from the last kernel:
// counters read back without it are not those of this run.
const uint entryCounter = 0u, nodePairCounter = 16u, trianglePairCounter = 32u, survivorCounter = 48u,
           skippedCounter = 64u, stoppedCounter = 80u, overflowCounter = 96u, finishedCounter = 112u,
           unorderedCounter = 128u;
// Words that the processor doesn't read: workgroups of the last kernel that are done; the kernels that have run, an octal
// digit each, behind the run's number.
const uint doneCounter = 113u, kernelCounter = 114u;
const uint nodesRan = 01u, nodePairsRan = 010u, trianglePairsRan = 0100u, pairTestsRan = 01000u;

uint kernelsOfRun(uint kernels)
{
    return runNumber << 12 | kernels;
}

// The last kernel's answer counts only if each kernel has run once: see its `finish`.
void countKernel(uint kernel)
{
    if (gl_LocalInvocationIndex == 0u && gl_WorkGroupID == uvec3(0u))
        atomicAdd(counters[kernelCounter], kernel);
}

// Adds items to a list's count, and notices a count that could wrap around. Returns the previous count.
uint append(uint counter, uint count)
{
    uint previous = atomicAdd(counters[counter], count);
    if (previous + count >= 0x80000000u)
        atomicMax(counters[overflowCounter], 1u);
    return previous;
}

const uint tileWords = 8u; // lower ends, then highest level - upper ends, so that both grow by atomicMin
const uint highestLevel = 0x7fffu;

// Flags of a body.
const uint isMoving = 1u, selfCollides = 2u;

bool bodySelfCollides(uint body)
{
    return (bodyWord(body, 2u) & selfCollides) != 0u;
}

// Whether a node's box meets the AABB of its body's partners.
#define IS_OF_INTEREST(box, body)                                                                                      \
    OVERLAP(box, uvec4(bodyWord(body, 4u), bodyWord(body, 5u), bodyWord(body, 6u), bodyWord(body, 7u)))

// A box of 15-bit levels: lower ends (x | y << 16, z | d << 16), upper ends likewise with the top bit of each half set.
// d is the diagonal (x + y) / 2. Two boxes overlap if no subtraction borrows from a top bit: upper - lower >= 0.
const uint guards = 0x80008000u;

#define OVERLAP(p, q) (((p.z - q.x) & (q.z - p.x) & (p.w - q.y) & (q.w - p.y) & guards) == guards)

uvec4 packBox(uvec4 lower, uvec4 upper)
{
    return uvec4(lower.x | lower.y << 16, lower.z | lower.w << 16, upper.x | upper.y << 16 | guards,
                 upper.z | upper.w << 16 | guards);
}

uvec4 lowerEnds(uvec4 box)
{
    return uvec4(box.x & 0x7fffu, box.x >> 16, box.y & 0x7fffu, box.y >> 16);
}

uvec4 upperEnds(uvec4 box)
{
    return uvec4(box.z & 0x7fffu, box.z >> 16 & 0x7fffu, box.w & 0x7fffu, box.w >> 16 & 0x7fffu);
}

// Boxes k and k + 1 of a qcBox8: by axis, lower ends, then complements of upper ends, two to a word.
#define WRITE_TWO_OF_GROUP(groups, at, k, lower, upper)                                                                \
    for (int axis = 0; axis < 3; axis++)                                                                               \
    {                                                                                                                  \
        int word = (at) + axis * 8 + ((k) >> 1);                                                                       \
        groups[word] = lower[0][axis] | lower[1][axis] << 16;                                                          \
        groups[word + 4] = ~(upper[0][axis] | upper[1][axis] << 16);                                                   \
    }

// Not below 1: an empty box ends at level 0 and begins at the highest, so it overlaps no other box.
uvec4 toLevels(vec4 x)
{
    return uvec4(clamp(x, 1.0, float(highestLevel)));
}

// The box of the triangle at a slot, rounded outward to levels.
void findBox(int slot, out uvec4 lower, out uvec4 upper)
{
    uvec4 t = texelFetch(triangles, slot);
    bool exists = t.x != none;
    vec3 a = texelFetch(vertices, int(exists ? t.x : 0u)).xyz * scale,
         b = texelFetch(vertices, int(exists ? t.y : 0u)).xyz * scale,
         c = texelFetch(vertices, int(exists ? t.z : 0u)).xyz * scale;
    vec3 d = 0.5 * vec3(a.x + a.y, b.x + b.y, c.x + c.y);
    vec4 low = vec4(min(a, min(b, c)), min(d.x, min(d.y, d.z))),
         high = vec4(max(a, max(b, c)), max(d.x, max(d.y, d.z)));
    lower = exists ? toLevels(low - slack) : uvec4(highestLevel);
    upper = exists ? toLevels(high + slack) : uvec4(0u);
}
