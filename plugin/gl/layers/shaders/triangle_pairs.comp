// A workgroup for each pair of nodes, from clusters to triangles that may be within the query distance: overlapping
// clusters, overlapping triangles except neighbours, then separating axes. These are one algorithm with
// kernels/separating_axis.inl.h: the same scale, gap and 17 axes (the processor also tries the line between the centres).
// Tests of `layers` run both with one body (QC_LAYERS_REFINE). Proof: plugin/docs/proofs/layers.md.
layout(std430, binding = 6) buffer Results { uvec2 outSurvivors[]; }; // a copy of the counters, then triangles of the step

const uint survivorsAt = COUNTER_WORDS / 2u;
// Pairs of clusters between two barriers: more would need more shared memory, and most pairs of nodes have fewer.
#define CLUSTERS_OF_ROUND 16u

//  ---- separating axes -----------------------------------------------------------------------------------------------

// The other corners of A and all of B, relative to the first corner of A.
vec3 b, c, d, e, f;
float gap; // required distance along an axis of length 1

// Whether the cross product of two vectors separates the triangles by more than the query distance. The axis need not be
// exact, but must be equal in all dot products: GLSL may evaluate an expression that is not `precise` anew for each use,
// and round it differently.
bool separates(vec3 first, vec3 second)
{
    precise vec3 axis = cross(first, second);
    float u = dot(axis, b), v = dot(axis, c), p = dot(axis, d), q = dot(axis, e), r = dot(axis, f);
    float size = abs(axis.x) + abs(axis.y) + abs(axis.z), required = size * gap;
    float above = min(p, min(q, r)) - max(0.0, max(u, v)), below = min(0.0, min(u, v)) - max(p, max(q, r));
    return max(above, below) > max(required, 1e-20);
}

// Whether the triangles at two slots are farther apart than the query distance.
bool areApart(uint s, uint t)
{
    uvec4 i0 = texelFetch(triangles, int(s)), i1 = texelFetch(triangles, int(t));
    vec3 a = texelFetch(vertices, int(i0.x)).xyz;
    b = texelFetch(vertices, int(i0.y)).xyz - a;
    c = texelFetch(vertices, int(i0.z)).xyz - a;
    d = texelFetch(vertices, int(i1.x)).xyz - a;
    e = texelFetch(vertices, int(i1.y)).xyz - a;
    f = texelFetch(vertices, int(i1.z)).xyz - a;
    vec3 largest = max(max(max(abs(b), abs(c)), max(abs(d), abs(e))), abs(f));
    float size = max(largest.x, max(largest.y, largest.z));
    // A power of two, so that no product below underflows.
    float up = uintBitsToFloat((254u << 23) - (floatBitsToUint(size) & 0x7f800000u));
    b *= up, c *= up, d *= up, e *= up, f *= up;
    gap = (4.0 * pointError + queryDistance) * up * 1.0001 + 4e-6;

    vec3 bc = c - b, de = e - d, df = f - d, ef = f - e;
    precise vec3 n = cross(b, c), m = cross(de, df);
    // No early exit: arithmetic costs less than branches.
    bool apart = separates(b, c);
    apart = separates(de, df) || apart;
    apart = separates(b, de) || apart;
    apart = separates(b, df) || apart;
    apart = separates(b, ef) || apart;
    apart = separates(c, de) || apart;
    apart = separates(c, df) || apart;
    apart = separates(c, ef) || apart;
    apart = separates(bc, de) || apart;
    apart = separates(bc, df) || apart;
    apart = separates(bc, ef) || apart;
    apart = separates(n, b) || apart;
    apart = separates(n, c) || apart;
    apart = separates(n, bc) || apart;
    apart = separates(m, de) || apart;
    apart = separates(m, df) || apart;
    apart = separates(m, ef) || apart;
    return apart;
}

//  ---- clusters and triangles ------------------------------------------------------------------------------------------

shared uvec4 boxesOfA[72], boxesOfB[72]; // of triangles, then of clusters
shared uint table;                       // pair masks of adjacent nodes, or none
shared uint clusterCount, clusters[64];  // overlapping ones: cluster + 8 * cluster
// Triangles of one round: slot in A's node | slot in B's << 6. First all that overlap, then those not proven apart.
shared uint queueCount, keptCount, queue[CLUSTERS_OF_ROUND * 64u];
shared uint firstKept;

bool mayCollide(uint a, uint b)
{
    uint groupA = bodyWord(a, 0u), groupB = bodyWord(b, 0u), ownerA = bodyWord(a, 3u);
    return a == b ||
           (((bodyWord(a, 2u) | bodyWord(b, 2u)) & isMoving) != 0u && (groupA & bodyWord(b, 1u)) != 0u &&
            (groupB & bodyWord(a, 1u)) != 0u && (ownerA == 0u || ownerA != bodyWord(b, 3u)));
}

// The pair mask of two clusters, see qcPairMask_Word; none where the table has no word.
uvec2 wordOf(uint bit)
{
    uvec2 some = texelFetch(tables, int(table)).xy, empty = texelFetch(tables, int(table + 1u)).xy;
    uint flagBit = 1u << (bit & 31u);
    uvec2 flag = bit < 32u ? uvec2(flagBit, 0u) : uvec2(0u, flagBit);
    uvec2 below = bit < 32u ? uvec2(flagBit - 1u, 0u) : uvec2(none, flagBit - 1u);
    ivec2 ranks = bitCount(some & below);
    uvec2 word = texelFetch(tables, int(table) + 2 + ranks.x + ranks.y).xy;
    return (some & flag) != uvec2(0u) ? word : (empty & flag) != uvec2(0u) ? uvec2(0u) : uvec2(none);
}

// Searches the links of node A for node B.
void findTable(uint firstLink, uint endLink, uint nodeB, uint k)
{
    uint link = firstLink + k;
    for (; link < endLink; link += 64u)
    {
        uvec2 adjacent = texelFetch(links, int(link)).xy;
        if (adjacent.x == nodeB)
            table = adjacent.y;
    }
    // Some implementations stop the loops of an invocation after 65 535 iterations.
    if (link < endLink)
        counters[stoppedCounter] = 1u;
}

// Lane u + 8 v: clusters u and v. Within one node: each pair of clusters once, and each cluster with itself.
void findClusters(bool isOneNode, bool hasTable, uint k)
{
    uint u = k & 7u, v = k >> 3;
    uvec4 p = boxesOfA[64u + u], q = boxesOfB[64u + v];
    if (OVERLAP(p, q) && (!isOneNode || u <= v) && (!hasTable || wordOf(k) != uvec2(0u)))
        clusters[atomicAdd(clusterCount, 1u)] = k;
}

// Lane s + 8 t: triangles s and t of two clusters.
void findTriangles(uint bit, bool isOneNode, bool hasTable, uint k)
{
    uint u = bit & 7u, v = bit >> 3, s = u * 8u + (k & 7u), t = v * 8u + (k >> 3);
    uvec4 p = boxesOfA[s], q = boxesOfB[t];
    if (!OVERLAP(p, q))
        return;
    bool isTested = !isOneNode || s < t;
    if (hasTable)
    {
        uvec2 word = wordOf(bit);
        isTested = ((k < 32u ? word.x : word.y) >> (k & 31u) & 1u) != 0u;
    }
    if (isTested)
        queue[atomicAdd(queueCount, 1u)] = s | t << 6;
}

// Tests the axes of all pairs in the queue. What is kept takes the places of pairs that were read before.
void testQueue(uvec2 pair, uint k)
{
    uint count = queueCount;
    for (uint base = 0u; base < count; base += 64u)
    {
        uint word = queue[min(base + k, count - 1u)];
        bool isKept = base + k < count && !areApart(pair.x * 64u + (word & 63u), pair.y * 64u + (word >> 6));
        barrier();
        if (isKept)
            queue[atomicAdd(keptCount, 1u)] = word;
    }
    barrier();
}

// The step's number of the triangle at a slot.
uint numberOf(uint slot, uint firstTriangle)
{
    return firstTriangle + texelFetch(triangles, int(slot)).w;
}

// One append for the round. `firsts`: the first triangles of both bodies.
void writeKept(uvec2 pair, uvec2 firsts, uint k)
{
    uint count = keptCount;
    if (k == 0u)
    {
        atomicAdd(counters[trianglePairCounter], queueCount);
        firstKept = count != 0u ? atomicAdd(counters[survivorCounter], count) : 0u;
    }
    barrier();
    for (uint i = k; i < count; i += 64u)
        outSurvivors[survivorsAt + min(firstKept + i, survivorCapacity)] =
            uvec2(numberOf(pair.x * 64u + (queue[i] & 63u), firsts.x), numberOf(pair.y * 64u + (queue[i] >> 6), firsts.y));
    barrier();
    if (k == 0u)
        queueCount = keptCount = 0u;
    barrier();
}

void main()
{
    MARK_FINISHED
    uint i = GROUP, k = gl_LocalInvocationID.x;
    if (i >= min(counters[nodePairCounter], nodePairCapacity))
        return;

    uvec2 pair = texelFetch(nodePairs, int(i)).xy;
    uvec3 node = texelFetch(nodes, int(pair.x)).xyz; // body, first link, end of links
    for (uint box = k; box < 72u; box += 64u)
    {
        boxesOfA[box] = texelFetch(boxes, int(pair.x) * BOXES_OF_NODE + int(box));
        boxesOfB[box] = texelFetch(boxes, int(pair.y) * BOXES_OF_NODE + int(box));
    }
    if (k == 0u)
    {
        table = none;
        clusterCount = queueCount = keptCount = 0u;
    }
    barrier();
    // Bodies that don't collide have no clusters.
    uint bodyB = texelFetch(nodes, int(pair.y)).x;
    uvec2 firsts = uvec2(bodyWord(node.x, 20u), bodyWord(bodyB, 20u));
    bool isTested = mayCollide(node.x, bodyB);
    if (isTested && testNeighbours == 0u)
        findTable(node.y, node.z, pair.y, k);
    barrier();
    bool isOneNode = pair.x == pair.y, hasTable = table != none;
    if (isTested)
        findClusters(isOneNode, hasTable, k);
    barrier();
    uint toDo = clusterCount;
    for (uint j = 0u; j < toDo;)
    {
        for (uint end = min(j + CLUSTERS_OF_ROUND, toDo); j < end; j++)
            findTriangles(clusters[j], isOneNode, hasTable, k);
        barrier();
        testQueue(pair, k);
        writeKept(pair, firsts, k);
    }
}
