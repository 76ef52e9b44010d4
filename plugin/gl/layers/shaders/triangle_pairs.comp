// Pairs of triangles whose boxes overlap, except neighbours: of overlapping clusters of pairs of nodes. 8 invocations for
// each pair of nodes, then 8 for each pair of clusters.
layout(std430, binding = 2) readonly buffer Boxes { uvec4 inBoxes[]; };
layout(std430, binding = 5) readonly buffer NodePairs { uvec4 inNodePairs[]; };
layout(std430, binding = SOURCE_BINDING) writeonly buffer TrianglePairs { uvec2 outTrianglePairs[]; }; // slots

const uint clustersOfRound = LOCAL_SIZE / 8u;

shared uvec4 pairs[MAX_NODE_PAIRS];                       // as in the list
shared uint clusterCount, clusters[64u * MAX_NODE_PAIRS]; // pair of nodes << 6 | clusters u + 8 v
shared uvec2 words[LOCAL_SIZE];                           // pairs of triangles of the clusters, s + 8 t
shared uint listed, firstListed;

// The pair mask of two clusters, see qcPairMask_Word; none where the table has no word.
uvec2 wordOf(uint table, uint bit)
{
    uvec2 some = texelFetch(tables, int(table)).xy, empty = texelFetch(tables, int(table + 1u)).xy;
    uint flagBit = 1u << (bit & 31u);
    uvec2 flag = bit < 32u ? uvec2(flagBit, 0u) : uvec2(0u, flagBit);
    if ((some & flag) == uvec2(0u))
        return (empty & flag) != uvec2(0u) ? uvec2(0u) : uvec2(none);
    ivec2 ranks = bitCount(some & (bit < 32u ? uvec2(flagBit - 1u, 0u) : uvec2(none, flagBit - 1u)));
    return texelFetch(tables, int(table) + 2 + ranks.x + ranks.y).xy;
}

// Pairs of triangles of two clusters, s + 8 t.
uvec2 wordOfClusters(uint cluster)
{
    uint bit = cluster & 63u, u = bit & 7u, v = bit >> 3;
    uvec4 pair = pairs[cluster >> 6];
    if (pair.z != none)
        return wordOf(pair.z, bit);
    // Within one node each pair once.
    return pair.x != pair.y || u < v ? uvec2(none) : u == v ? uvec2(0x07030100u, 0x7f3f1f0fu) : uvec2(0u);
}

// Overlapping clusters: cluster v of a pair's second node with those of the first.
void findClusters(uint count, uint k)
{
    uint p = k >> 3, v = k & 7u, hits = 0u;
    if (p >= count)
        return;
    uvec4 box = inBoxes[pairs[p].y * uint(BOXES_OF_NODE) + 64u + v];
    for (uint u = 0u; u < 8u; u++)
    {
        uvec4 other = inBoxes[pairs[p].x * uint(BOXES_OF_NODE) + 64u + u];
        hits |= OVERLAP(box, other) ? 1u << u : 0u;
    }
    uint place = hits != 0u ? atomicAdd(clusterCount, uint(bitCount(hits))) : 0u;
    for (; hits != 0u; hits &= hits - 1u)
        clusters[place++] = p << 6 | v << 3 | uint(findLSB(hits));
}

// Slots of triangle s of the first cluster and triangle 0 of the second.
uvec2 slotsOf(uint cluster, uint s)
{
    return pairs[cluster >> 6].xy * 64u + uvec2((cluster & 7u) * 8u + s, cluster & 56u);
}

// Element of the boxes.
uint boxOf(uint slot)
{
    return (slot >> 6) * uint(BOXES_OF_NODE) + (slot & 63u);
}

// The triangles of the second cluster that overlap triangle s of the first, a bit each.
uint findTriangles(uint cluster, uvec2 word, uint s)
{
    uvec2 slots = slotsOf(cluster, s);
    uvec4 box = inBoxes[boxOf(slots.x)];
    uint hits = 0u, others = boxOf(slots.y);
    for (uint t = 0u; t < 8u; t++)
    {
        uvec4 other = inBoxes[others + t];
        bool isTested = ((t < 4u ? word.x : word.y) >> (s + 8u * (t & 3u)) & 1u) != 0u;
        hits |= isTested && OVERLAP(box, other) ? 1u << t : 0u;
    }
    return hits;
}

// Lists the overlapping triangles of some pairs of clusters, LOCAL_SIZE at most. One append for all.
void addClusters(uint base, uint count, uint k)
{
    if (k < count)
        words[k] = wordOfClusters(clusters[base + k]);
    if (k == 0u)
        listed = 0u;
    barrier();
    uvec2 hits = uvec2(0u); // 8 bits a round
    for (uint item = k >> 3, round = 0u; item < count; item += clustersOfRound, round++)
    {
        uint ofRound = findTriangles(clusters[base + item], words[item], k & 7u) << 8u * (round & 3u);
        hits |= round < 4u ? uvec2(ofRound, 0u) : uvec2(0u, ofRound);
    }
    ivec2 bits = bitCount(hits);
    uint place = hits != uvec2(0u) ? atomicAdd(listed, uint(bits.x + bits.y)) : 0u;
    barrier();
    if (k == 0u && listed != 0u)
        firstListed = append(trianglePairCounter, listed);
    barrier();
    for (place += firstListed; hits != uvec2(0u); place++)
    {
        uint bit = uint(hits.x != 0u ? findLSB(hits.x) : 32 + findLSB(hits.y));
        hits = hits.x != 0u ? uvec2(hits.x & hits.x - 1u, hits.y) : uvec2(0u, hits.y & hits.y - 1u);
        uvec2 slots = slotsOf(clusters[base + (bit >> 3) * clustersOfRound + (k >> 3)], k & 7u);
        outTrianglePairs[min(place, trianglePairCapacity)] = uvec2(slots.x, slots.y + (bit & 7u));
    }
    barrier();
}

// The triangles of pairs of nodes, MAX_NODE_PAIRS at most.
void addNodes(uint first, uint count, uint k)
{
    if (k < count)
        pairs[k] = inNodePairs[first + k];
    if (k == 0u)
        clusterCount = 0u;
    barrier();
    findClusters(count, k);
    barrier();
    uint inAll = clusterCount;
    for (uint base = 0u; base < inAll; base += LOCAL_SIZE)
        addClusters(base, min(inAll - base, LOCAL_SIZE), k);
    barrier();
}

void main()
{
    countKernel(trianglePairsRan);
    uint k = gl_LocalInvocationID.x, groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y, first = GROUP * nodePairsOfGroup;
    // With too small a list the kernels run again.
    uint inList = counters[nodePairCounter], count = inList <= nodePairCapacity ? inList : 0u;
    for (; first < count; first += groups * nodePairsOfGroup)
        addNodes(first, min(count - first, nodePairsOfGroup), k);
    if (first < count)
        counters[stoppedCounter] = 1u;
}
