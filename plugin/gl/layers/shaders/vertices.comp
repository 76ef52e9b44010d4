// Transforms vertices of rigid bodies from local space to the grid frame. A chunk is 64 vertices of one body.
layout(std430, binding = 1) buffer Vertices { vec4 outVertices[]; };
// xyz: bits of a position about the body's centre; w: the body's slot. Integer texels: a small integer read as a float is
// denormal, and GLSL allows denormals to become 0.
uniform usamplerBuffer locals;
uniform usamplerBuffer chunks;
uniform uint chunkCount;

void main()
{
    uint i = ITEM;
    if (i >= chunkCount * 64u)
        return;

    int v = int(texelFetch(chunks, int(i >> 6)).x * 64u + (i & 63u));
    uvec4 bits = texelFetch(locals, v);
    vec3 local = uintBitsToFloat(bits.xyz);
    int body = int(bits.w) * BODY_TEXELS;
    vec4 x = uintBitsToFloat(texelFetch(bodies, body + 2)), y = uintBitsToFloat(texelFetch(bodies, body + 3)),
         z = uintBitsToFloat(texelFetch(bodies, body + 4));
    outVertices[v] = vec4(dot(x.xyz, local) + x.w, dot(y.xyz, local) + y.w, dot(z.xyz, local) + z.w, 0.0);
}
