// Shared code of the kernels of `layers`. The README.md of gl/layers gives their order. Proof: plugin/docs/proofs/layers.md.
layout(local_size_x = LOCAL_SIZE) in;

// Uploaded when bodies are added or move.
uniform samplerBuffer vertices;           // in the frame; see gl/layers/layers_gpu.h
uniform usamplerBuffer triangles;         // by slot: three vertices; x = none: no triangle
uniform usamplerBuffer nodes, links, tables;
uniform usamplerBuffer bodies;            // BODY_TEXELS each
uniform usamplerBuffer activeNodes;
// Made in this step.
uniform usamplerBuffer boxes, clusterBoxes, nodeBoxes, entries, nodePairs, nodePairTables, clusterPairs, trianglePairs;

layout(std430, binding = 0) buffer Counters { uint counters[]; };
uniform usamplerBuffer counted; // the counters as a texture, which takes a tenth of the time to read on llvmpipe

const uint none = 0xffffffffu;

// The image's cells: pixels, each cut into slices of depth. A cell is 2^shift levels of each axis.
uniform uvec3 cellShift;

uint cellAt(uvec3 at)
{
    return (at.z << 15u - cellShift.y | at.y) << 15u - cellShift.x | at.x;
}

// One invocation per item: a loop over several items takes twice as long on llvmpipe.
#define ITEM ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

// Indices of the counters, each on a cache line of its own. For a list: the number of items, then the workgroup counts of
// the kernel that reads it.
const int entryCounter = 0, nodePairCounter = 16, clusterPairCounter = 32, trianglePairCounter = 48,
          survivorCounter = 64, skippedCounter = 80, stoppedCounter = 96, overflowCounter = 112, finishedCounter = 128;

// The last kernel writes the run's number: counters read back without it are not those of this run.
uniform uint runNumber;
#define MARK_FINISHED                                                                                                  \
    if (ITEM == 0u)                                                                                                    \
        counters[finishedCounter] = runNumber;

// Flags of a body.
const uint isMoving = 1u, selfCollides = 2u;

bool bodySelfCollides(uint body)
{
    return (texelFetch(bodies, int(body) * BODY_TEXELS).z & selfCollides) != 0u;
}

// Number of items in a list of an earlier kernel.
uint countOf(int counter, uint capacity)
{
    return min(texelFetch(counted, counter).x, capacity);
}

// Adds items to a list's count, and workgroups for those that fit. Returns the previous count.
uint append(int counter, uint count, uint capacity)
{
    uint previous = atomicAdd(counters[counter], count);
    uint consumerSize = CONSUMER_SIZES[counter / 16],
         groups = (min(previous + count, capacity) + consumerSize - 1u) / consumerSize;
    if (groups > (previous + consumerSize - 1u) / consumerSize)
    {
        atomicMax(counters[counter + 1], min(groups, GROUPS_IN_ROW));
        atomicMax(counters[counter + 2], (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW);
    }
    return previous;
}

// A box of 15-bit levels: lower ends (x | y << 16, z | d << 16), upper ends likewise with the top bit of each half set.
// d is the diagonal (x + y) / 2. Two boxes overlap if no subtraction borrows from a top bit: upper - lower >= 0.
const uint guards = 0x80008000u;
const uvec4 emptyBox = uvec4(0x7fff7fffu, 0x7fff7fffu, guards, guards);

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
#define WRITE_TWO_OF_GROUP(groups, group, k, lower, upper)                                                             \
    for (int axis = 0; axis < 3; axis++)                                                                               \
    {                                                                                                                  \
        int word = (group) * 24 + axis * 8 + ((k) >> 1);                                                               \
        groups[word] = lower[0][axis] | lower[1][axis] << 16;                                                          \
        groups[word + 4] = ~(upper[0][axis] | upper[1][axis] << 16);                                                   \
    }

// Eight boxes against eight: bit u + 8 v of the mask (low, high word) is set if u of the one overlaps v of the other.
#define OVERLAP_BIT(p, q, bit) (OVERLAP(p, q) ? 1u << (bit) : 0u)
#define ROW(q, bit)                                                                                                    \
    (OVERLAP_BIT(p0, q, bit) | OVERLAP_BIT(p1, q, bit + 1) | OVERLAP_BIT(p2, q, bit + 2) |                             \
     OVERLAP_BIT(p3, q, bit + 3) | OVERLAP_BIT(p4, q, bit + 4) | OVERLAP_BIT(p5, q, bit + 5) |                         \
     OVERLAP_BIT(p6, q, bit + 6) | OVERLAP_BIT(p7, q, bit + 7))
#define EIGHT_AGAINST_EIGHT(source, first, second, mask)                                                               \
    uvec4 p0 = texelFetch(source, first), p1 = texelFetch(source, first + 1), p2 = texelFetch(source, first + 2),      \
          p3 = texelFetch(source, first + 3), p4 = texelFetch(source, first + 4), p5 = texelFetch(source, first + 5),  \
          p6 = texelFetch(source, first + 6), p7 = texelFetch(source, first + 7);                                      \
    uvec4 q0 = texelFetch(source, second), q1 = texelFetch(source, second + 1), q2 = texelFetch(source, second + 2),   \
          q3 = texelFetch(source, second + 3);                                                                         \
    mask.x &= ROW(q0, 0) | ROW(q1, 8) | ROW(q2, 16) | ROW(q3, 24);                                                     \
    q0 = texelFetch(source, second + 4), q1 = texelFetch(source, second + 5), q2 = texelFetch(source, second + 6),     \
    q3 = texelFetch(source, second + 7);                                                                               \
    mask.y &= ROW(q0, 0) | ROW(q1, 8) | ROW(q2, 16) | ROW(q3, 24);

// Writes item << 6 | bit for each bit of the mask. One atomic per invocation: atomics cost most on a CPU. A list has room
// for one item more than its capacity: items that do not fit go there, without a branch.
#define WRITE_BITS(list, capacity, counter, item, mask)                                                                \
    uint count = uint(bitCount(mask.x) + bitCount(mask.y));                                                            \
    if (count != 0u)                                                                                                   \
    {                                                                                                                  \
        uint at = append(counter, count, capacity);                                                                    \
        for (; (mask.x | mask.y) != 0u; at++)                                                                          \
        {                                                                                                              \
            bool isLow = mask.x != 0u;                                                                                 \
            uint word = isLow ? mask.x : mask.y, bit = uint(findLSB(word)) + (isLow ? 0u : 32u);                       \
            word &= word - 1u;                                                                                         \
            mask = isLow ? uvec2(word, mask.y) : uvec2(0u, word);                                                      \
            list[min(at, capacity)] = item << 6 | bit;                                                                 \
        }                                                                                                              \
    }
