// Overlapping clusters of two nodes, if the rules of their bodies allow the pair.
layout(std430, binding = 1) buffer ClusterPairs { uint outClusterPairs[]; }; // node pair << 6 | cluster + 8 * cluster
layout(std430, binding = 2) buffer NodePairTables { uint outNodePairTables[]; }; // pair masks of adjacent nodes, or none
uniform uint nodePairCapacity, clusterPairCapacity;

bool mayCollide(uint a, uint b)
{
    uvec4 p = texelFetch(bodies, int(a) * BODY_TEXELS), q = texelFetch(bodies, int(b) * BODY_TEXELS);
    return a == b || (((p.z | q.z) & isMoving) != 0u && (p.x & q.y) != 0u && (q.x & p.y) != 0u &&
                      (p.w == 0u || p.w != q.w));
}

void main()
{
    uint i = ITEM;
    if (i >= countOf(nodePairCounter, nodePairCapacity))
        return;

    uvec2 pair = texelFetch(nodePairs, int(i)).xy;
    uvec3 node = texelFetch(nodes, int(pair.x)).xyz; // body, first link, end of links
    uint table = none, k = node.y;
    for (; k < node.z; k++)
    {
        uvec2 link = texelFetch(links, int(k)).xy;
        table = link.x == pair.y ? link.y : table;
    }
    // Some implementations stop the loops of an invocation after 65 535 iterations.
    if (k < node.z)
        counters[stoppedCounter] = 1u;
    outNodePairTables[i] = table;
    // Within one node: each pair of clusters once, and each cluster with itself.
    uvec2 mask = pair.x == pair.y ? uvec2(0x0f070301u, 0xff7f3f1fu) : uvec2(none);
    mask = mayCollide(node.x, texelFetch(nodes, int(pair.y)).x) ? mask : uvec2(0u);
    EIGHT_AGAINST_EIGHT(clusterBoxes, int(pair.x * 8u), int(pair.y * 8u), mask)
    WRITE_BITS(outClusterPairs, clusterPairCapacity, clusterPairCounter, i, mask)
}
