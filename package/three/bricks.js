// Probes of '.ylmp' in three.js: light for the standard materials.

import { Data3DTexture, DataTexture, FileLoader, HalfFloatType, IntType, LinearFilter, RGBAFormat, RGIntegerFormat, Vector3 } from 'three';
import { readProbes } from './probes.js';
import shader from './shader.js';

const LIT = [ 'Standard', 'Physical', 'Lambert', 'Phong', 'Toon' ].map( name => `isMesh${ name }Material` );

const USE = /* glsl */`
#if defined( RE_IndirectDiffuse )
	irradiance += ylm_irradiance( ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz,
		transformNormalByInverseViewMatrix( geometryNormal, viewMatrix ) );
#endif
`;

export class BrickProbes {

	constructor( buffer ) {

		const p = readProbes( buffer ), tree = new DataTexture( p.tree.data, p.tree.width, p.tree.height, RGIntegerFormat, IntType );
		tree.internalFormat = 'RG32I';
		tree.needsUpdate = true;
		const atlas = new Data3DTexture( p.atlas.data, ...p.atlas.size );
		atlas.format = RGBAFormat;
		atlas.type = HalfFloatType;
		atlas.minFilter = atlas.magFilter = LinearFilter;
		atlas.needsUpdate = true;
		this.uniforms = { ylm_tree: { value: tree }, ylm_bricks: { value: atlas } };
		for ( const [ name, x ] of Object.entries( p.uniforms ) ) this.uniforms[ name ] = { value: x.length ? new Vector3( ...x ) : x };

	}

	// Adds the probes' light to a material.
	patch( material ) {

		material.onBeforeCompile = program => {

			Object.assign( program.uniforms, this.uniforms );
			program.fragmentShader = program.fragmentShader.replace( 'void main() {', shader + 'void main() {' )
				.replace( '#include <lights_fragment_maps>', USE + '#include <lights_fragment_maps>' );

		};

		material.customProgramCacheKey = () => 'ylm-probes';
		material.needsUpdate = true;

	}

	// Adds it to all lit materials of an object.
	light( object ) {

		object.traverse( o => [ o.material ?? [] ].flat().filter( m => LIT.some( is => m[ is ] ) ).forEach( m => this.patch( m ) ) );

	}

}

// ( await loadBrickProbes( 'room.ylmp' ) ).light( scene );
export async function loadBrickProbes( url ) {

	return new BrickProbes( await new FileLoader().setResponseType( 'arraybuffer' ).loadAsync( url ) );

}
